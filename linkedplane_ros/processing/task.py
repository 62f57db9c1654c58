# SPDX-License-Identifier: Apache-2.0
"""One recording: joint angles in, the same with the muscle's state beside them out.

A recording is processed in chunks. Tasks share nothing; `workers` runs many.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter

import numpy as np

from .. import __version__
from ..errors import LinkedPlaneError, RecordingError
from ..joints.articulation import Articulation
from ..muscle.broad_muscle import BroadMuscle
from ..recordings.bag_motion import BagMotion
from ..recordings.bone_frames import BoneFrames
from ..recordings.formats import TABLES, check_format
from ..recordings.motion import Chunk, Motion, Refusals
from ..recordings.smoothing import SmoothedMotion
from ..recordings.table_motion import TableMotion
from ..skeleton.girdle import HUMERUS, Rest
from ..skeleton.still_second import NOT_STILL, find_rest
from ..solver.linked_plane_solver import LinkedPlaneSolver
from ..types import Floats
from .bag_output import BagOutput
from .options import Options
from .outputs import (
    CsvOutput,
    Output,
    OutputDescription,
    ParquetOutput,
    SolvedChunk,
    choose_format,
    facts_file,
    is_facts_file,
    replace_output,
)
from .plausibility import Plausibility


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


def open_motion(task: Task) -> Motion:
    """Open a task's recording; RecordingError if it cannot be used."""
    options, source = task.options, task.source
    convention, bones = options.joint_convention, options.bones
    motion: Motion
    check_format(source)
    if source.suffix.lower() in TABLES:
        if bones is not None:
            raise RecordingError(f'{source}: a table has no frames; --humerus is for bags')
        motion = TableMotion(source, options.joint_map, options.degrees, options.time)
    elif options.time is not None:
        raise RecordingError(f'{source}: a bag has stamps; --time is for tables')
    elif bones is not None:
        if options.rests_still:
            bones = replace(bones, rest=read_rest(source, bones, options.side))
        motion = BagMotion.from_poses(source, bones, convention, options.side)
    else:
        motion = BagMotion.from_joint_states(
            source, options.joint_map, options.topic, options.degrees
        )
    if options.rate is None and options.lowpass is None and not options.differentiate:
        return motion
    return SmoothedMotion(motion, options.rate, options.lowpass)


def read_rest(source: Path, bones: BoneFrames, side: str) -> Rest:
    """Return the rest with the humerus' of the first still second; RecordingError if there is none.

    Parameters
    ----------
    source
        The bag.
    bones
        Of the poses in it: the humerus against the thorax.
    side
        'right' or 'left': which shoulder the frames are of.
    """
    motion = BagMotion.from_poses(source, replace(bones, rhythm=None), HUMERUS, side)
    motion.keeps_records = False
    still = find_rest(
        (stamp, {'humerus': HUMERUS.rotation(angles)})
        for chunk in motion.chunks()
        for stamp, angles in zip(chunk.stamps.tolist(), chunk.angles, strict=True)
    )
    if still.rest is None:
        raise RecordingError(
            f'{source}: --rest still: {NOT_STILL}; give --rest PROTRACTION LATERAL TILT PLANE '
            'ELEVATION, rad, or leave it out'
        )
    return replace(bones.rest or still.rest, humerus=still.rest.humerus)


def describe_output(task: Task, muscle: BroadMuscle, motion: Motion) -> OutputDescription:
    """Return what a task's output says of itself."""
    options, convention = task.options, task.options.joint_convention
    angles_topic = ''
    if isinstance(motion, TableMotion):
        angles_topic = '/joint_states'
    elif isinstance(motion, SmoothedMotion) or options.bones or motion.unit.degrees:
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
        'joint_convention': convention.name,
        'rotation': convention.formula,
        **motion.facts,
        'resampled_to_hz': 'no' if options.rate is None else f'{options.rate:g}',
        'lowpass_hz': lowpass,
        'angles_topic': angles_topic,
        'units': 'm, rad, s; moment arms: positive where shortening turns the joint up',
    }
    return OutputDescription(
        muscle, convention.coordinates, options.frame_id, facts, angles_topic, options.markers
    )


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


def solve_chunk(
    chunk: Chunk, solver: LinkedPlaneSolver, moved_by: Articulation, refused: Refusals
) -> SolvedChunk:
    """Solve a chunk; refuse and leave out frames at which a band has no plane.

    Parameters
    ----------
    chunk
        Values of the coordinates.
    solver
        Of the muscle and the side.
    moved_by
        What moves the muscle's bones.
    refused
        Where refused frames are counted.
    """
    try:
        answers = solver.answer_batch(moved_by, chunk.angles, chunk.speeds)
    except LinkedPlaneError:
        good = np.array([has_planes(solver, moved_by, each) for each in chunk.angles])
        for stamp in chunk.stamps[~good].tolist():
            refused.add('no_plane', f'stamp {1e-9 * stamp:.2f} s: a band has no plane')
        if good.all():
            raise
        return solve_chunk(chunk.select(good), solver, moved_by, refused)
    return SolvedChunk(chunk, answers.states, answers.moment_arms, answers.lengthening)


def has_planes(solver: LinkedPlaneSolver, moved_by: Articulation, values: Floats) -> bool:
    """Return whether every band has a plane at values (d,) of the coordinates."""
    try:
        solver.answer(moved_by, values, np.zeros_like(values))
    except LinkedPlaneError:
        return False
    return True


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
    begin = perf_counter()  # all is compiled
    kind = choose_format(task.target, options.kind)
    targets, facts = [task.target], facts_file(task.target)
    if options.plain:
        if kind != 'csv':
            raise RecordingError(f'{task.target}: --plain is for .csv; the output is {kind}')
        if facts.exists() and not is_facts_file(facts):
            raise RecordingError(f'{facts}: exists, and --plain did not write it: not replaced')
        targets.append(facts)
    motion = open_motion(task)
    motion.keeps_records = motion.keeps_records and kind == 'bag'
    plausibility = Plausibility(muscle, options, motion)
    with ExitStack() as stack:
        replaced = (replace_output(each, options.force, kind == 'bag') for each in targets)
        beside = [stack.enter_context(each) for each in replaced]
        description = describe_output(task, muscle, motion)
        with closing(open_output(beside, kind, description, motion)) as out:
            for chunk in motion.chunks():
                each = solve_chunk(chunk, solver, convention, motion.refused)
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
        (*refused.notes, *refused.warn()),
        plausibility.outside,
        plausibility.warning,
        refused.most,
    )


def report_failure(task: Task, error: Exception) -> Report:
    """Return the report of a task that ended with an unexpected error."""
    text = (str(error).splitlines() or [''])[0]
    return Report(task, fault=f'{task.source}: not processed: {type(error).__name__}: {text}')
