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
from ..processing.motion_source import MotionSource
from ..skeleton.followed_girdle import FollowedGirdle
from ..skeleton.joint_tree import list_names
from ..skeleton.lost_plane import caution_of
from ..solver.linked_plane_solver import LinkedPlaneSolver
from .articulated_frames import TF_INPUT, articulate_frames
from .articulations import NOTHING, Articulations, Received, articulate, check_combination
from .parameters import SPECS

ONES, NONE = [1.0, 1.0, 1.0], [0.0, 0.0, 0.0]  # joint_signs and joint_offsets by default


@dataclass(frozen=True)
class Settings:
    """All parameters, checked and turned into what the node works with."""

    solvers: tuple[LinkedPlaneSolver, ...]
    """One for each muscle; their names differ."""
    left_out: Mapping[str, str]
    """The given muscles that cannot be used, each with the reason."""
    scale: str
    convention: JointConvention
    articulations: Articulations
    """What moves the bones."""
    sources: tuple[MotionSource, ...]
    """How the poses in /tf move each muscle's bones; none where joint states do."""
    joints: JointMap
    joint_timeout: float
    """s; 0: for ever."""
    frame_id: str
    markers_enabled: bool
    markers_rate: float
    markers_points: int
    markers_details: bool

    @property
    def cautions(self) -> Iterator[str]:
        """What the streams usually measure, and which bones do not move, a line each."""
        facts = self.articulations.facts
        if 'skeleton' in facts:
            if self.scale != '1':
                yield f'scale {self.scale} is of the muscle; the skeleton stays as its URDF has it'
            return
        for moved_by in self.articulations.moved_by[:1]:  # one rhythm for all muscles
            if isinstance(moved_by, FollowedGirdle) and not self.sources:
                yield from caution_of(moved_by.convention, moved_by.rhythm)
        if self.convention.caution and 'rhythm' not in facts and not self.sources:
            yield self.convention.caution
        if held := facts.get('bones held at rest'):
            last = self.solvers[0].bones[-1]
            yield f'{held}: held at rest, only the {last} moves; a skeleton or a rhythm moves all'

    @staticmethod
    def from_values(
        values: Mapping[str, Any],
        may_fail: Collection[str] = (),
        received: Received = NOTHING,
    ) -> Settings:
        """Return the settings of a whole set of parameters.

        Parameters
        ----------
        values
            One for each parameter, by name.
        may_fail
            Muscles that are left out if they cannot be loaded, as long as another one is left.
        received
            What has come on topics.

        Raises
        ------
        LinkedPlaneError
            It names the parameter that cannot be used, its value, and what is expected.

        """
        with refusals('parameters'):
            return _build_settings(check_values(values), may_fail, received)


def _build_settings(
    checked: Mapping[str, Any], may_fail: Collection[str], received: Received
) -> Settings:
    muscles, left_out = load_muscles(list_muscles(checked['muscle']), checked['scale'], may_fail)
    solvers = tuple(LinkedPlaneSolver(muscle, checked['side']) for muscle in muscles)
    sources: tuple[MotionSource, ...] = ()
    if checked['input'] == TF_INPUT:
        articulations, sources = articulate_frames(checked, solvers, received)
    else:
        articulations = articulate(checked, solvers, received)
    still = (0.0,) * len(articulations.coordinates)
    for solver, moved_by in zip(solvers, articulations.moved_by, strict=False):
        solver.answer(moved_by, still, still)  # compiled before it is needed
    return Settings(
        solvers=solvers,
        left_out=left_out,
        scale=checked['scale'],
        convention=JOINT_CONVENTIONS[checked['joint_convention']],
        articulations=articulations,
        sources=sources,
        joints=map_joints(checked, articulations),
        joint_timeout=checked['joint_timeout'],
        frame_id=checked['frame_id'],
        markers_enabled=checked['markers.enabled'],
        markers_rate=checked['markers.rate'],
        markers_points=checked['markers.points'],
        markers_details=checked['markers.details'],
    )


def map_joints(checked: Mapping[str, Any], moved: Articulations) -> JointMap:
    """Return which joints are the coordinates, one sign and offset for each.

    Raises
    ------
    LinkedPlaneError
        For lists of another length; three signs or offsets that are the default suit any.

    """
    coordinates, d = moved.coordinates, len(moved.coordinates)
    if moved.awaited and not d:
        return JointMap((), (), ())
    lists = []
    for name, default in (('joint_names', []), ('joint_signs', ONES), ('joint_offsets', NONE)):
        given = checked[name]
        if len(given) != d and given != default:
            raise LinkedPlaneError(
                f'parameter {name}: {len(given)} given, {d} expected, one for each coordinate: '
                f'{list_names(coordinates, most=d)}'
            )
        lists.append(given)
    names, signs, offsets = lists
    names = tuple(names) or coordinates
    idle = (each for each, at in zip(names, coordinates, strict=True) if at in moved.idle)
    return JointMap(
        names,
        tuple(signs) if len(signs) == d else (1.0,) * d,
        tuple(offsets) if len(offsets) == d else (0.0,) * d,
        moved.kinds,
        frozenset(idle),
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
    joints = None if values['skeleton'] else 3  # of a skeleton, how many says its URDF
    checked: dict[str, Any] = {spec.name: spec.check(values[spec.name], joints) for spec in SPECS}
    check_combination(checked)
    if any(abs(sign) != 1.0 for sign in checked['joint_signs']):
        raise LinkedPlaneError(
            f'parameter joint_signs: {checked["joint_signs"]} given, 1.0 or -1.0 expected'
        )
    if joints and any(abs(offset) > FULL_CIRCLE for offset in checked['joint_offsets']):
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
