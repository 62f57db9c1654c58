# SPDX-License-Identifier: Apache-2.0
"""What moves the bones where their poses come in /tf, by the node's parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import LinkedPlaneError, describe_value
from ..joints.articulation import rest_poses
from ..processing.motion_source import MotionSource, choose_motion_source
from ..processing.options import Options
from ..skeleton.skeleton import Skeleton
from ..solver.linked_plane_solver import LinkedPlaneSolver
from .articulations import BY_TOPIC, STILL_SECOND, Articulations, Received

TF_INPUT = 'tf'


def articulate_frames(
    checked: Mapping[str, Any], solvers: Sequence[LinkedPlaneSolver], received: Received
) -> tuple[Articulations, tuple[MotionSource, ...]]:
    """Return what moves the bones of each muscle, and the frames that say where they are.

    Raises
    ------
    LinkedPlaneError
        For parameters that do not suit the muscles, and for a rest that joint states have to say.
    """
    if STILL_SECOND in checked['rest']:
        given = describe_value(checked['rest'])
        raise LinkedPlaneError(f'parameter rest: {given} given with input tf; numbers expected')
    name, skeleton = checked['skeleton'], None
    facts = {'input': '/tf, /tf_static'}
    if name == BY_TOPIC:
        if received.urdf is None:
            awaited = f'a URDF on the topic {BY_TOPIC} (skeleton: {BY_TOPIC})'
            waiting = Articulations(
                facts=facts, summary=f'skeleton {name}', by_topic=True, awaited=awaited
            )
            return waiting, ()
        skeleton = Skeleton.from_urdf(received.urdf, BY_TOPIC)
    try:
        options = read_options(checked)
        sources = tuple(choose_motion_source(options, each, skeleton) for each in solvers)
    except LinkedPlaneError as error:
        text = str(error).removeprefix('--')
        raise LinkedPlaneError(f'parameter {text}') from None
    for solver, source in zip(solvers, sources, strict=True):
        compile_answer(solver, source)
    first = sources[0]
    assert first.frames is not None
    listed = ', '.join(f'{bone} {frame}' for bone, frame in first.frames.names.items())
    facts |= {'frames': listed, 'frame axes': first.frames.axes}
    if name:
        facts['skeleton'] = name
    else:
        facts['joint convention'] = options.convention
    if first.frames.at_rest is not None:
        facts['frames at rest'] = first.frames.facts['frames_at_rest']
    if first.frames.rhythm is not None:
        facts['rhythm'] = str(first.frames.rhythm)
    of = f'skeleton {name}' if name else options.convention
    articulations = Articulations(
        tuple(source.moved_by for source in sources),
        first.coordinates,
        first.moved_by.kinds,
        frozenset(first.coordinates),
        facts,
        f'{of}; frames of /tf: {listed}',
        by_topic=name == BY_TOPIC,
    )
    return articulations, sources


def tf_message_class() -> Any:
    """Return the class of /tf's messages; LinkedPlaneError where its package is not there."""
    try:
        from tf2_msgs.msg import TFMessage
    except ImportError:
        raise LinkedPlaneError(
            'parameter input: tf needs the package tf2_msgs, which a ROS installation has (apt '
            'install ros-jazzy-tf2-msgs) and PyPI has not'
        ) from None
    return TFMessage


def read_options(checked: Mapping[str, Any]) -> Options:
    """Return the parameters as the command `process` has them."""
    words = checked['rest'].replace(',', ' ').split()
    try:
        rest = [float(word) for word in words] or None
    except ValueError:
        given = describe_value(checked['rest'])
        raise LinkedPlaneError(f'rest: {given} given, 3 or 5 numbers in rad expected') from None
    return Options(
        input=TF_INPUT,
        side=checked['side'],
        convention=checked['joint_convention'],
        bone_links=tuple(filter(None, checked['bone_links'])) or None,
        skeleton=checked['skeleton'] or None,
        rest_frames=tuple(filter(None, checked['rest_frames'])) or None,
        rhythm=checked['rhythm'] or None,
        rest=rest,
        frame_axes=checked['frame_axes'],
    )


def compile_answer(solver: LinkedPlaneSolver, source: MotionSource) -> None:
    """Answer once before it is needed, where whole poses are."""
    if source.reading is None or source.frames is None:
        return
    poses = rest_poses(1, len(source.frames.names) - 1)
    measured = source.reading.read_poses(poses)
    values = measured.values[0]
    solver.answer(measured, values, np.zeros_like(values))
