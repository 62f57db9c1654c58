# SPDX-License-Identifier: Apache-2.0
"""From the values of all parameters to what the node works with: solvers, joints, markers."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..errors import LinkedPlaneError
from ..joints.conventions import JOINT_CONVENTIONS, JointConvention
from ..joints.joint_state import JointMap
from ..muscle.broad_muscle import BroadMuscle
from ..solver.linked_plane_solver import LinkedPlaneSolver
from .parameters import SPECS

STILL = (0.0, 0.0, 0.0)  # rad, rad/s


@dataclass(frozen=True)
class Settings:
    """All parameters, checked and turned into what the node works with."""

    solvers: tuple[LinkedPlaneSolver, ...]
    """One for each muscle; their names differ."""
    left_out: Mapping[str, str]
    """The given muscles that cannot be used, each with the reason."""
    scale: str
    convention: JointConvention
    joints: JointMap
    frame_id: str
    markers_enabled: bool
    markers_rate: float
    markers_points: int
    markers_details: bool

    @staticmethod
    def from_values(values: Mapping[str, Any], may_fail: Collection[str] = ()) -> Settings:
        """Return the settings of a whole set of parameters.

        Parameters
        ----------
        values
            One for each parameter, by name.
        may_fail
            Muscles that are left out if they cannot be loaded, as long as another one is left.

        Raises
        ------
        LinkedPlaneError
            It names the parameter that cannot be used, its value, and what is expected.

        """
        checked = check_values(values)
        convention = JOINT_CONVENTIONS[checked['joint_convention']]
        solvers, left_out = build_solvers(
            list_muscles(checked['muscle']), checked['scale'], checked['side'], convention, may_fail
        )
        return Settings(
            solvers=solvers,
            left_out=left_out,
            scale=checked['scale'],
            convention=convention,
            joints=JointMap(
                tuple(checked['joint_names']) or convention.coordinates,
                tuple(checked['joint_signs']),
                tuple(checked['joint_offsets']),
            ),
            frame_id=checked['frame_id'],
            markers_enabled=checked['markers.enabled'],
            markers_rate=checked['markers.rate'],
            markers_points=checked['markers.points'],
            markers_details=checked['markers.details'],
        )


def check_values(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of all parameters, checked as far as no muscle has to be loaded.

    Raises
    ------
    LinkedPlaneError
        As `Settings.from_values`.

    """
    checked: dict[str, Any] = {spec.name: spec.check(values[spec.name]) for spec in SPECS}
    if any(abs(sign) != 1.0 for sign in checked['joint_signs']):
        raise LinkedPlaneError(
            f'parameter joint_signs: {checked["joint_signs"]} given, 1.0 or -1.0 expected'
        )
    frame = checked['frame_id']
    if not frame or frame.startswith('/'):
        fault = "starts with '/'" if frame else 'is empty'
        raise LinkedPlaneError(
            f'parameter frame_id: {frame!r} given, the name of a frame expected; tf2 has none '
            f'that {fault}'
        )
    return checked


def list_muscles(value: Any) -> list[str]:
    """Return the muscles in a value of the parameter `muscle`; none if it has another type."""
    items = [value] if isinstance(value, str) else value
    return [str(item) for item in items] if isinstance(items, Sequence) else []


def build_solvers(
    muscles: Sequence[str],
    scale: str,
    side: str,
    convention: JointConvention,
    may_fail: Collection[str],
) -> tuple[tuple[LinkedPlaneSolver, ...], dict[str, str]]:
    """Return a solver for each muscle, and the reason for each that was left out."""
    solvers: dict[str, LinkedPlaneSolver] = {}
    given: dict[str, str] = {}
    left_out: dict[str, str] = {}
    for text in muscles:
        try:
            solver = LinkedPlaneSolver(BroadMuscle.load(text).scaled(scale), side)
            solver.answer(convention, STILL, STILL)  # compiled before it is needed
        except LinkedPlaneError as error:
            if text not in may_fail:
                raise
            left_out[text] = str(error)
            continue
        name = solver.muscle.name
        if name in solvers:
            raise LinkedPlaneError(
                f'parameter muscle: {given[name]!r} and {text!r} are both named {name}, the prefix '
                'of their topics; different names expected'
            )
        solvers[name], given[name] = solver, text
    if not solvers:
        raise LinkedPlaneError('; '.join(dict.fromkeys(left_out.values())))
    return tuple(solvers.values()), left_out
