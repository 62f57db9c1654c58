# SPDX-License-Identifier: Apache-2.0
"""`linkedplane process`: recordings in, recordings with the muscle's state out."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

from ..errors import LinkedPlaneError, escape_controls
from ..files import find_abandoned, workshop_of
from ..joints.conventions import JOINT_CONVENTIONS, THESIS_CONVENTION
from .argument_types import (
    add_muscle,
    add_scale,
    add_side,
    number_or_still,
    positive_count,
    positive_number,
    sign,
)
from .progress import ProgressBar

if TYPE_CHECKING:
    from ..processing.task import Report, Task


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the command takes."""
    # fmt: off
    add = parser.add_argument
    add('inputs', nargs='+', metavar='INPUT',
        help='bags, .mot, .sto, .csv or .tsv files, folders of them, or patterns like *.mot')
    add('out', metavar='OUT', help='a bag, .csv or .parquet; a folder for several inputs')
    add('--format', dest='kind', choices=('bag', 'csv', 'parquet'),
        help="of the output (default: by OUT's ending, else bag)")
    add('--force', action='store_true', help='replace an output that exists')
    # fmt: on
    _add_angles(parser.add_argument_group('where the angles come from'))
    _add_poses(parser.add_argument_group('poses of bones instead of angles'))
    _add_motion(parser.add_argument_group('what is done to the motion'))
    _add_output(parser.add_argument_group('the muscle and the output'))
    _add_work(parser.add_argument_group('how the work is shared'))


def _add_angles(angles: argparse._ArgumentGroup) -> None:
    # fmt: off
    add = angles.add_argument
    add('--convention', choices=tuple(JOINT_CONVENTIONS), default=THESIS_CONVENTION.name,
        help='the joint convention: what the angles mean (default: %(default)s)')
    add('--joints', nargs=3, metavar='NAME',
        help="the three joints or columns, in the convention's order (default: its coordinates)")
    add('--signs', nargs=3, type=sign, metavar='SIGN',
        help='1 or -1 for each joint: angle = sign * recorded + offset (default: 1 1 1)')
    add('--offsets', nargs=3, type=float, metavar='RAD',
        help="added to each joint's angle, rad, a full turn at most (default: 0 0 0)")
    unit = angles.add_mutually_exclusive_group()
    unit.add_argument('--degrees', action='store_true', default=None,
        help='the recorded angles are in degrees (default: as the recording says, else rad)')
    unit.add_argument('--radians', dest='degrees', action='store_false', default=None,
        help='they are in rad')
    add('--time', metavar='NAME',
        help='the column of the time in a table, in s unless its name ends in ms, us or ns '
        '(default: time, t, timestamp, Time (Seconds), __time, ...)')
    add('--topic', metavar='NAME',
        help='the topic of joint states in a bag (default: /joint_states, or the only one)')
    add('--skeleton', metavar='NAME',
        help="the bones move by a skeleton's joints: shoulder_girdle, hip, or a .urdf file; "
        'moment arms are about its joints (default: a ball joint)')
    add('--joint-names', nargs='+', metavar='JOINT:=NAME',
        help='the joints of the --skeleton that are recorded under other names')
    add('--rhythm', metavar='NAME',
        help='the angles are against the thorax, and the scapula follows the humerus: '
        'constant_ratio, de_groot_brand_2001, mobl, '
        'or a number, the ratio of glenohumeral to scapulothoracic elevation '
        '(default: with --thorax and no --scapula 2, else none)')
    add('--rest', nargs='+', type=number_or_still, metavar='RAD',
        help='where the rhythm starts from: the scapula with the arm hanging, protraction, lateral '
        "rotation, tilt, rad, and, if known, the humerus' plane of elevation and elevation there; "
        'still, after the three or alone: the humerus as in the first second in which it hangs '
        "still (default: the thorax's axes for a ratio, else the angles of an average subject)")
    # fmt: on


def _add_poses(poses: argparse._ArgumentGroup) -> None:
    # fmt: off
    add = poses.add_argument
    add('--humerus', metavar='NAME',
        help='take the motion from poses: a topic, or a frame in /tf')
    add('--scapula', metavar='NAME', help='what the humerus is measured against')
    add('--clavicle', metavar='NAME', help='the same of the clavicle, for a muscle that has one')
    add('--thorax', metavar='NAME',
        help='without --scapula, what the humerus is measured against: the scapula follows by a '
        'rhythm (--rhythm); with it, the base of a --skeleton that has a thorax')
    add('--input', choices=('joint_states', 'tf'),
        help="tf: the frames in /tf of all bones of the muscle, by the bones' names or --bone-links"
        ' (default: tf where frames are named, else joint_states)')
    add('--bone-links', nargs='+', metavar='BONE:=LINK',
        help='the links of the --skeleton, or the frames of --input tf, that are not named as the '
        'bones')
    add('--rest-frames', nargs='+', metavar='[BONE:=]WHERE',
        help="where the bones' frames stand at the muscle's rest: coincide (with the ground's), "
        "first (as in the first frame), X,Y,Z,ROLL,PITCH,YAW in the ground bone's frame (m, rad), "
        'or as the links of a skeleton at 0 (default: those of --skeleton; without, coincide, '
        'unless one begins more than 50 mm away: first, with a warning)')
    add('--frame-axes', choices=('model', 'isb'),
        help='axes of the frames. model: x to the right, y anterior, z superior; '
        'isb: x anterior, y superior, z to the right (default: model)')
    # fmt: on


def _add_motion(motion: argparse._ArgumentGroup) -> None:
    # fmt: off
    add = motion.add_argument
    add('--rate', type=positive_number, metavar='HZ',
        help='resample the angles at HZ (default: as recorded)')
    add('--lowpass', type=positive_number, metavar='HZ',
        help='filter the angles first, without lag: Butterworth, cutoff at HZ (default: no filter)')
    add('--differentiate', action='store_true',
        help='velocities by differences, even where some were recorded')
    # fmt: on


def _add_output(output: argparse._ArgumentGroup) -> None:
    # fmt: off
    add_muscle(output)
    add_scale(output)
    add_side(output)
    add = output.add_argument
    add('--frame-id', default='scapula', metavar='NAME',
        help='the frame of the outputs, at most 255 characters without blanks '
        '(default: %(default)s)')
    add('--plain', action='store_true',
        help='a .csv that begins with its header; what else it would say stands in OUT.facts.yaml')
    add('--no-markers', dest='markers', action='store_false', help='leave the markers out of a bag')
    # fmt: on


def _add_work(work: argparse._ArgumentGroup) -> None:
    # fmt: off
    add = work.add_argument
    add('--jobs', type=positive_count, default=1, metavar='N',
        help='recordings at a time (default: %(default)s)')
    add('--dask', metavar='ADDRESS', help='work on the Dask cluster at ADDRESS (default: here)')
    # fmt: on


def run(args: argparse.Namespace) -> None:
    """Write recordings again, with the muscle's state beside the motion."""
    from ..processing.inputs import build_tasks, find_recordings, is_single
    from ..processing.options import Options
    from ..processing.workers import run_tasks
    from ..skeleton.lost_plane import caution_of
    from ..skeleton.rhythms import rhythm_from

    options = Options(**{field.name: getattr(args, field.name) for field in fields(Options)})
    if options.follows:
        rhythm = rhythm_from(options.rhythm or 'constant_ratio')
        print(f'angles against the thorax: the scapula follows the humerus by {rhythm} '
              '(--rhythm), an assumption')  # fmt: skip
    convention = options.joint_convention
    cautions: Iterable[str] = filter(None, [convention.caution])
    if options.follows:
        cautions = caution_of(convention, rhythm)
    if not (options.has_poses or options.skeleton):
        for caution in cautions:
            print(f'linkedplane: {caution}', file=sys.stderr)
    out = Path(args.out)
    sources, faults = find_recordings(args.inputs)
    single = is_single(args.inputs, sources, out)
    tasks, clashes = build_tasks(sources, out, single, options)
    faults += clashes
    for fault in faults:
        print(f'linkedplane: {escape_controls(fault)}', file=sys.stderr)
    if tasks and not (single and tasks[0].target == out):
        try:
            out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise LinkedPlaneError(f'{out}: no folder to write into: {error.strerror}') from None
    name_abandoned(tasks)
    failed = doubtful = 0
    with sigterm_as_exit(), ProgressBar() as bar:

        def show_progress(frames: int, share: float) -> None:
            bar.update(share, f'{frames:,} frames')

        for report in run_tasks(tasks, args.jobs, args.dask, show_progress):
            failed += bool(report.fault)
            doubtful += report.mostly_refused
            with bar.paused():
                print_report(report)
    if len(tasks) > 1:
        print(f'{len(tasks) - failed} of {len(tasks)} recordings processed into {out}')
    if failed or doubtful or faults:
        raise SystemExit(1)


def name_abandoned(tasks: Sequence[Task]) -> None:
    """Print what killed runs left in the folders of the outputs, and how to remove it."""
    reused = {workshop_of(task.target) for task in tasks}
    for path in find_abandoned({task.target.parent for task in tasks}):
        remedy = 'it is removed now' if path in reused else f'remove it: rm -r {quote(str(path))}'
        print(f'linkedplane: warning: {path}: left by a run that was killed; {remedy}',
              file=sys.stderr)  # fmt: skip


def print_report(report: Report) -> None:
    """Print what has become of a recording: a line, and one for each kind of refused frame."""
    task = report.task
    if report.fault:
        print(f'linkedplane: {escape_controls(report.fault)}', file=sys.stderr)
        return
    refused = sum(report.refused.values())
    rate = report.frames / max(report.seconds, 1e-9)
    line = f'{task.source} -> {task.target}: {report.frames:,} frames, {rate:,.0f} a second'
    if refused:
        line += f', {refused:,} refused'
    if report.outside:
        line += f", {report.outside:,} outside the model's range of motion"
    print(escape_controls(line))
    for reason, count in report.refused.items():
        where = escape_controls(report.first[reason])
        print(f'  {count:,} refused as {reason}, first at {where}')
    for note in report.notes:
        if note.startswith('warning: '):
            print(f'linkedplane: {escape_controls(note)}', file=sys.stderr)
        else:
            print(f'  {escape_controls(note)}')
    if report.mostly_refused:
        print(f'linkedplane: warning: {task.source}: most frames were refused; {task.target} has '
              'only the others', file=sys.stderr)  # fmt: skip
    if report.warning:
        print(f'linkedplane: warning: {task.source}: {report.warning}', file=sys.stderr)


@contextmanager
def sigterm_as_exit() -> Iterator[None]:
    """Let SIGTERM end the block as SIGINT does: nothing half-written stays."""

    def end(*_: object) -> None:
        raise SystemExit(143)

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
