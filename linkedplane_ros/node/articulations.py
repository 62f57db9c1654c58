# SPDX-License-Identifier: Apache-2.0
"""What moves the bones of the node's muscles, by its parameters and by what came on topics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from ..errors import LinkedPlaneError, SkeletonError, describe_value
from ..joints.articulation import Articulation, name_unit
from ..joints.conventions import JOINT_CONVENTIONS
from ..skeleton.followed_girdle import FollowedGirdle
from ..skeleton.girdle import Rest
from ..skeleton.joint_tree import list_names
from ..skeleton.rhythms import rhythm_from
from ..skeleton.skeleton import Skeleton, parse_bone_links
from ..solver.linked_plane_solver import LinkedPlaneSolver
from .topics import ROBOT_DESCRIPTION

BY_TOPIC = ROBOT_DESCRIPTION.name
STILL_SECOND = 'still'


@dataclass(frozen=True)
class Received:
    """What the settings need beside parameters, as far as it has come."""

    urdf: str | None = None
    """The newest URDF on the topic of robot descriptions."""
    rest: Rest | None = None
    """The rest of the stream's first still second."""


NOTHING = Received()


@dataclass(frozen=True)
class Articulations:
    """What moves the bones of each muscle."""

    moved_by: tuple[Articulation, ...] = ()
    """One for each solver; none while the skeleton has still to come."""
    coordinates: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    idle: frozenset[str] = frozenset()
    """The coordinates that move no bone of any muscle."""
    facts: Mapping[str, str] = field(default_factory=dict)
    """What the diagnostics say of it."""
    summary: str = ''
    """What the log says of it."""
    measures: str = ''
    """What the joints are measured against, and in which unit."""
    by_topic: bool = False
    """Whether the skeleton is that of the topic of robot descriptions."""
    awaited: str = ''
    """What has still to come before anything is answered; empty: nothing."""
    finds_rest: bool = False
    """Whether the stream's first still second is awaited."""


def check_combination(checked: Mapping[str, Any]) -> None:
    """Refuse parameters that do not go together; LinkedPlaneError names both."""
    skeleton, rhythm = checked['skeleton'], checked['rhythm']
    if skeleton and rhythm:
        raise LinkedPlaneError(
            f'parameter rhythm: {describe_value(rhythm)} given beside skeleton '
            f'{describe_value(skeleton)}; one of them expected: a skeleton moves all bones itself'
        )
    if any(checked['bone_links']) and not skeleton and checked['input'] != 'tf':
        given = describe_value(checked['bone_links'])
        raise LinkedPlaneError(
            f'parameter bone_links: {given} given, only with a skeleton or input tf'
        )
    for name, default in ('rest_frames', ['']), ('frame_axes', 'model'):
        if checked[name] != default and checked['input'] != 'tf':
            given = describe_value(checked[name])
            raise LinkedPlaneError(f'parameter {name}: {given} given, only with input tf')
    if checked['rest'] and not rhythm:
        given = describe_value(checked['rest'])
        raise LinkedPlaneError(f'parameter rest: {given} given, only with a rhythm')


def list_coordinates(checked: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the coordinates by checked parameters; none where a topic has yet to say them."""
    name = checked['skeleton']
    if not name:
        return JOINT_CONVENTIONS[checked['joint_convention']].coordinates
    return () if name == BY_TOPIC else Skeleton.load(name).coordinates


def articulate(
    checked: Mapping[str, Any], solvers: Sequence[LinkedPlaneSolver], received: Received
) -> Articulations:
    """Return what moves the bones of each muscle, by checked parameters.

    Raises
    ------
    LinkedPlaneError
        For a skeleton, a rhythm or a rest that cannot be used, and for bones they do not move.

    """
    if checked['skeleton']:
        links = _parse_links(checked['bone_links'], solvers)
        try:
            return _by_skeleton(checked['skeleton'], links, solvers, received.urdf)
        except SkeletonError as error:
            text = str(error).removeprefix('skeleton: ')
            raise SkeletonError(f'parameter skeleton: {text}') from None
    convention = JOINT_CONVENTIONS[checked['joint_convention']]
    facts = {'joint convention': convention.name, 'rotation': convention.formula}
    moved_by: Articulation = convention
    finds_rest = False
    if checked['rhythm']:
        rhythm = _parse_rhythm(checked['rhythm'])
        words = checked['rest'].replace(',', ' ').split()
        waits = words[-1:] == [STILL_SECOND]
        numbers = words[:-1] if waits else words
        rest = _parse_rest(numbers) if numbers else None
        finds_rest = waits and received.rest is None
        if waits and received.rest is not None:
            rest = replace(rest or received.rest, humerus=received.rest.humerus)
        moved_by = FollowedGirdle(convention, rhythm, rest)
        facts['rhythm'], facts['rest'] = str(rhythm), str(rest or 'an average subject')
        measures = f'humerus against thorax, rad; rhythm {rhythm}, rest {facts["rest"]}'
    else:
        held = dict.fromkeys(bone for solver in solvers for bone in solver.bones[1:-1])
        if held:
            facts['bones held at rest'] = ', '.join(held)
        measures = 'humerus against scapula, rad'
    return Articulations(
        (moved_by,) * len(solvers),
        convention.coordinates,
        convention.kinds,
        facts=facts,
        summary=f'{convention.name}: {convention.formula}',
        measures=measures,
        awaited='the arm to hang still for a second (rest: still)' if finds_rest else '',
        finds_rest=finds_rest,
    )


def _parse_links(entries: Sequence[str], solvers: Sequence[LinkedPlaneSolver]) -> Mapping[str, str]:
    """Return the links of bones that some muscle has, from the parameter `bone_links`."""
    try:
        links = parse_bone_links(filter(None, entries))
    except SkeletonError as error:
        raise SkeletonError(f'parameter {error}') from None
    owned = {bone for solver in solvers for bone in solver.bones}
    unknown = [bone for bone in links if bone not in owned]
    if unknown:
        raise SkeletonError(
            f'parameter bone_links: {describe_value(unknown[0])} is no bone of '
            f'{", ".join(solver.muscle.name for solver in solvers)}; those are '
            f'{list_names(sorted(owned))}'
        )
    return links


def _by_skeleton(
    name: str,
    links: Mapping[str, str],
    solvers: Sequence[LinkedPlaneSolver],
    urdf: str | None,
) -> Articulations:
    facts = {'skeleton': name}
    if name == BY_TOPIC:
        if urdf is None:
            awaited = f'a URDF on the topic {BY_TOPIC} (skeleton: {BY_TOPIC})'
            return Articulations(
                facts=facts, summary=f'skeleton {name}', by_topic=True, awaited=awaited
            )
        loaded = Skeleton.from_urdf(urdf, BY_TOPIC)
    else:
        loaded = Skeleton.load(name)
    skeletons = tuple(
        loaded.for_bones(
            solver.bones, {bone: link for bone, link in links.items() if bone in solver.bones}
        )
        for solver in solvers
    )
    moving = {name for skeleton in skeletons for name in skeleton.moving}
    if not moving:
        bones = list_names(skeletons[0].bones)
        raise SkeletonError(f'{name}: no joint moves the bones {bones} against each other')
    ground, *others = skeletons[0].bones
    facts['bones'] = f'{ground} (ground), {", ".join(others)}'
    if loaded.side:
        facts['side of the skeleton'] = loaded.side
    return Articulations(
        skeletons,
        loaded.coordinates,
        loaded.kinds,
        frozenset(loaded.coordinates) - moving,
        facts,
        f'skeleton {name}: {facts["bones"]}',
        name_unit(loaded.kinds),
        name == BY_TOPIC,
    )


def _parse_rhythm(text: str) -> Any:
    try:
        return rhythm_from(text)
    except LinkedPlaneError as error:
        raise LinkedPlaneError(f'parameter {error}') from None


def _parse_rest(words: Sequence[str]) -> Rest:
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        given = describe_value(' '.join(words))
        raise LinkedPlaneError(
            f"parameter rest: {given} given, '{STILL_SECOND}', 3 or 5 numbers in rad expected"
        ) from None
    return Rest.from_numbers(numbers, 'parameter rest')
