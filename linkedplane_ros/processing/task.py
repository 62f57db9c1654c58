# SPDX-License-Identifier: Apache-2.0
"""One recording: joint angles in, the same with the muscle's state beside them out.

A recording is processed in chunks. Tasks share nothing; `workers` runs many.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter

from .. import __version__
from ..errors import LinkedPlaneError, RecordingError
from ..joints.conventions import JointConvention
from ..muscle.broad_muscle import BroadMuscle
from ..recordings.motion import Motion
from ..recordings.smoothing import SmoothedMotion
from ..recordings.table_motion import TableMotion
from ..skeleton.followed_girdle import FollowedGirdle
from ..solver.linked_plane_solver import LinkedPlaneSolver
from .bag_output import BagOutput
from .motion_source import MotionSource, choose_motion_source
from .opening import open_motion, settle_rest
from .options import Options
from .outputs import (
    CsvOutput,
    Output,
    OutputDescription,
    ParquetOutput,
    choose_format,
    facts_file,
    is_facts_file,
    replace_output,
)
from .plausibility import Plausibility
from .solving import begin_solving


@dataclass(frozen=True)
class Task:
    """One recording to be processed."""

    source: Path
    target: Path
    options: Options = field(default_factory=Options)


@dataclass(frozen=True)
class Report:
    """The result of a task."""

    task: Task
    frames: int = 0
    """How many frames the output has."""
    seconds: float = 0.0
    """How long it took, without compiling."""
    refused: Mapping[str, int] = field(default_factory=dict)
    """How many frames were refused, by reason."""
    first: Mapping[str, str] = field(default_factory=dict)
    """Where each reason was first met."""
    notes: Sequence[str] = ()
    """What else is worth knowing, a line each."""
    outside: int = 0
    """Frames outside the range of motion of the model."""
    warning: str = ''
    """What is to be doubted of the output, in one line; empty: nothing."""
    mostly_refused: bool = False
    """Whether more of the frames were refused than could be used."""
    fault: str = ''
    """Why there is no output, in one line; empty: there is one."""


def describe_output(
    task: Task, muscle: BroadMuscle, motion: Motion, moved: MotionSource
) -> OutputDescription:
    """Return what a task's output says of itself."""
    options, convention = task.options, task.options.joint_convention
    angles_topic = ''
    if isinstance(motion, TableMotion):
        angles_topic = '/joint_states'
    elif isinstance(motion, SmoothedMotion) or moved.frames or motion.unit.degrees:
        angles_topic = f'/{muscle.name}/joint_states'
    lowpass = 'no'
    if options.lowpass is not None:
        lowpass = f'{options.lowpass:g} (Butterworth, both ways: no lag)'
    facts = {
        'made_by': f'linkedplane_ros {__version__}',
        'source': task.source.name,
        'muscle': muscle.name,
        'model': options.muscle,
        'model_source': muscle.source,
        'scale': options.scale,
        'heads': json.dumps({head.name: head.bands for head in muscle.heads}),
        'side': options.side,
        **motion.facts,
        **describe_coordinates(moved, convention),
        'resampled_to_hz': 'no' if options.rate is None else f'{options.rate:g}',
        'lowpass_hz': lowpass,
        'angles_topic': angles_topic,
        'units': 'm, rad, s; moment arms: positive where shortening turns the joint up',
    }
    bones = muscle.bones.names[1:] if len(muscle.bones.names) > 2 else ()
    return OutputDescription(
        muscle, moved.coordinates, options.frame_id, facts, angles_topic, options.markers, bones
    )


def describe_coordinates(moved: MotionSource, convention: JointConvention) -> dict[str, str]:
    """Return what the coordinates mean, for an output's metadata."""
    moved_by = moved.moved_by
    facts = {'joint_convention': convention.name, 'rotation': convention.formula}
    if moved.skeleton:
        facts = {
            'joint_convention': f'joints of {moved.skeleton}',
            'coordinates': json.dumps(moved.coordinates),
        }
        if moved.joints is None:
            facts['angles_from'] = 'the joints that fit the poses best'
    if moved.held:
        facts['bones_held_at_rest'] = ', '.join(moved.held)
    if isinstance(moved_by, FollowedGirdle):
        facts['against'] = 'thorax; moment arms include what follows'
        facts['scapulohumeral_rhythm'] = str(moved_by.rhythm)
        if moved_by.rest is not None:
            facts['scapula_at_rest'] = str(moved_by.rest)
    return facts


def open_output(
    paths: Sequence[Path], kind: str, description: OutputDescription, motion: Motion
) -> Output:
    """Open an output of a kind, bag, csv or parquet, for the frames of a motion.

    A second path is where the facts of a plain CSV are written.
    """
    path = paths[0]
    if kind == 'csv':
        return CsvOutput(path, description, *paths[1:])
    if kind == 'parquet':
        return ParquetOutput(path, description)
    return BagOutput(path, description, motion.path if motion.keeps_records else None)


Progress = Callable[[int, float], None]


def run_task(task: Task, progress: Progress = lambda frames, share: None) -> Report:
    """Process one recording; a fault is reported, not raised.

    Parameters
    ----------
    task
        The recording, its output and the options.
    progress
        Called after each chunk with the frames done and the share of the recording, 0 to 1.
    """
    try:
        return _run(task, progress)
    except LinkedPlaneError as error:
        return Report(task, fault=str(error))
    except Exception as error:  # the other recordings are still processed
        return report_failure(task, error)


def _run(task: Task, progress: Progress) -> Report:
    options, convention = task.options, task.options.joint_convention
    muscle = BroadMuscle.load(options.muscle).scaled(options.scale)
    solver = LinkedPlaneSolver(muscle, options.side)
    convention.rotation((0.0, 0.0, 0.0))
    moved = settle_rest(task.source, options, choose_motion_source(options, solver))
    begin = perf_counter()  # all is compiled
    kind = choose_format(task.target, options.kind)
    targets, facts = [task.target], facts_file(task.target)
    if options.plain:
        if kind != 'csv':
            raise RecordingError(f'{task.target}: --plain is for .csv; the output is {kind}')
        if facts.exists() and not is_facts_file(facts):
            raise RecordingError(f'{facts}: exists, and --plain did not write it: not replaced')
        targets.append(facts)
    motion = open_motion(task.source, options, moved)
    solving = begin_solving(solver, moved, motion.refused)
    motion.keeps_records = motion.keeps_records and kind == 'bag'
    plausibility = Plausibility(muscle, options, motion, moved)
    with ExitStack() as stack:
        replaced = (replace_output(each, options.force, kind == 'bag') for each in targets)
        beside = [stack.enter_context(each) for each in replaced]
        description = describe_output(task, muscle, motion, moved)
        with closing(open_output(beside, kind, description, motion)) as out:
            for chunk in motion.chunks():
                each = solving.solve(chunk)
                out.write(each)
                plausibility.extend(each)
                progress(plausibility.frames, chunk.share)
        if not plausibility.frames:
            first = next(iter(motion.refused.first.values()), 'no frames in it')
            raise RecordingError(f'{task.source}: nothing was usable: {first}')
        plausibility.check_unit()
    if kind == 'csv' and options.force and not options.plain and is_facts_file(facts):
        facts.unlink()  # of a plain CSV that was there before
    refused = motion.refused
    return Report(
        task,
        plausibility.frames,
        perf_counter() - begin,
        dict(refused.counts),
        dict(refused.first),
        (*refused.notes, *refused.warn(), *solving.notes, *plausibility.notes),
        plausibility.outside,
        plausibility.warning,
        refused.most,
    )


def report_failure(task: Task, error: Exception) -> Report:
    """Return the report of a task that ended with an unexpected error."""
    text = (str(error).splitlines() or [''])[0]
    return Report(task, fault=f'{task.source}: not processed: {type(error).__name__}: {text}')
