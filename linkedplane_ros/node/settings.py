# SPDX-License-Identifier: Apache-2.0
"""From the values of all parameters to what the node works with: solvers, joints, markers."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from ..errors import LinkedPlaneError, describe_value, escape_controls
from ..joints.conventions import JOINT_CONVENTIONS, JointConvention
from ..joints.frame_names import check_frame_name
from ..joints.joint_state import FULL_CIRCLE, JointMap
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
    joint_timeout: float
    """s; 0: for ever."""
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
        with refusals('parameters'):
            return _build_settings(check_values(values), may_fail)


def _build_settings(checked: Mapping[str, Any], may_fail: Collection[str]) -> Settings:
    convention = JOINT_CONVENTIONS[checked['joint_convention']]
    muscles, left_out = load_muscles(list_muscles(checked['muscle']), checked['scale'], may_fail)
    solvers = tuple(LinkedPlaneSolver(muscle, checked['side']) for muscle in muscles)
    for solver in solvers:
        solver.answer(convention, STILL, STILL)  # compiled before it is needed
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
        joint_timeout=checked['joint_timeout'],
        frame_id=checked['frame_id'],
        markers_enabled=checked['markers.enabled'],
        markers_rate=checked['markers.rate'],
        markers_points=checked['markers.points'],
        markers_details=checked['markers.details'],
    )


@contextmanager
def refusals(what: str) -> Iterator[None]:
    """Turn any exception into a LinkedPlaneError: no value ends a running node.

    Parameters
    ----------
    what
        Is at fault; where it is not an error of ours, the line begins with it.

    """
    try:
        yield
    except LinkedPlaneError:
        raise
    except Exception as error:
        text = escape_controls(f'{what}: cannot be used: {type(error).__name__}: {error}')
        raise LinkedPlaneError(text) from error


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
    if any(abs(offset) > FULL_CIRCLE for offset in checked['joint_offsets']):
        raise LinkedPlaneError(
            f'parameter joint_offsets: {describe_value(checked["joint_offsets"])} given, '
            'a full turn (2 pi rad) either way at most expected'
        )
    check_frame_name('parameter frame_id', checked['frame_id'])
    return checked


def list_muscles(value: Any) -> list[str]:
    """Return the muscles in a value of the parameter `muscle`; none if it has another type."""
    items = [value] if isinstance(value, str) else value
    return [str(item) for item in items] if isinstance(items, Sequence) else []


def load_muscles(
    given: Sequence[str], scale: str, may_fail: Collection[str]
) -> tuple[list[BroadMuscle], dict[str, str]]:
    """Return the muscles that are given, and the reason for each that was left out.

    Raises
    ------
    LinkedPlaneError
        If one that may not fail cannot be loaded, if none can, or if two have one name.

    """
    loaded: dict[str, BroadMuscle] = {}
    texts: dict[str, str] = {}
    left_out: dict[str, str] = {}
    for text in given:
        try:
            with refusals(f'parameter muscle: {describe_value(text)}'):
                muscle = BroadMuscle.load(text).scaled(scale)
        except LinkedPlaneError as error:
            if text not in may_fail:
                raise
            left_out[text] = str(error)
            continue
        if muscle.name in loaded:
            raise LinkedPlaneError(
                f'parameter muscle: {texts[muscle.name]!r} and {text!r} are both named '
                f'{muscle.name}, the prefix of their topics; different names expected'
            )
        loaded[muscle.name], texts[muscle.name] = muscle, text
    if not loaded:
        raise LinkedPlaneError('; '.join(dict.fromkeys(left_out.values())))
    return list(loaded.values()), left_out
