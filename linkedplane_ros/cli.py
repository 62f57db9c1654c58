"""The command `linkedplane`: look at a model, solve a pose; play, process, plot recordings.

Exit status: 0 done, 1 the input is at fault (one line on stderr says what and where), 2 usage.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from . import __version__
from .conventions import JOINT_CONVENTIONS, SIDES
from .model import BroadMuscle
from .solver import LinkedPlaneSolver, WrapState

if TYPE_CHECKING:
    from .process import Report


def info(args: argparse.Namespace) -> None:
    """Print a muscle model."""
    muscle = BroadMuscle.load(args.muscle)
    state = LinkedPlaneSolver(muscle).solve(np.eye(3))
    print(f'{muscle.name}: {len(muscle.band_names)} bands, {len(muscle.heads)} heads')
    print(muscle.source)
    print('right shoulder; x lateral, y anterior, z superior; lengths in mm, angles in rad')
    print()
    print(f'{"band":<14}{"head":<12}{"origin (scapula)":>24}{"insertion (humerus)":>24}'
          f'{"radius":>8}{"phi":>8}{"length":>8}  wrap')  # fmt: skip
    for i, band in enumerate(muscle.band_names):
        origin, insertion = (
            ' '.join(f'{1e3 * x:7.1f}' for x in point[i])
            for point in (muscle.origins, muscle.insertions)
        )
        phi = 'theta' if i == 0 else f'{muscle.plane_angles[i]:.3f}'
        print(f'{band:<14}{muscle.head_of(band):<12}{origin:>24}{insertion:>24}'
              f'{1e3 * muscle.sphere_radii[i]:8.1f}{phi:>8}{1e3 * state.lengths[i]:8.1f}'
              f'  {WrapState(state.wrap[i]).name.lower()}')  # fmt: skip
    print()
    print(f'arm at the side: theta {state.theta:.6f} rad, total {1e3 * state.total_length:.3f} mm')
    for head in muscle.heads:
        print(f'{head.name}: {", ".join(head.bands)}; represented by {head.represented_by}')


def solve(args: argparse.Namespace) -> None:
    """Print the muscle at one pose."""
    convention = JOINT_CONVENTIONS[args.convention]
    angles = np.array(args.angles) * (math.pi / 180.0 if args.degrees else 1.0)
    if not args.degrees and np.abs(angles).max() > 2.0 * math.pi:
        raise ValueError(f'{np.abs(angles).max():g} rad is more than a full turn; --degrees?')
    solver = LinkedPlaneSolver(BroadMuscle.load(args.muscle), args.side)
    state = solver.solve(convention.rotation(angles))
    arms = state.moment_vectors @ convention.axes(angles, args.side)
    names = solver.muscle.band_names
    if args.json:
        answer = {
            'muscle': solver.muscle.name,
            'side': args.side,
            'convention': convention.name,
            'coordinates': convention.coordinates,
            'angles_rad': angles.tolist(),
            'theta_rad': state.theta,
            'bands': names,
            'lengths_m': state.lengths.tolist(),
            'moment_arms_m': arms.tolist(),
            'moment_vectors_m': state.moment_vectors.tolist(),
            'wrap': [WrapState(w).name for w in state.wrap],
        }
        print(json.dumps(answer, indent=2))
        return
    pose = ', '.join(
        f'{name} {math.degrees(angle):.2f} deg'
        for name, angle in zip(convention.coordinates, angles, strict=True)
    )
    print(f'{solver.muscle.name}, {args.side} shoulder, humerus against scapula: {pose}')
    print(f'{convention.name}: {convention.formula}')
    print('moment arms: positive where shortening turns the joint in the positive direction')
    print()
    columns = ''.join(f'{name[:20]:>21}' for name in convention.coordinates)
    print(f'{"band":<14}{"length":>10}{columns}  wrap')
    print(f'{"":<14}{"mm":>10}' + f'{"mm":>21}' * 3)
    for name, length, arm, wrap in zip(names, state.lengths, arms, state.wrap, strict=True):
        row = ''.join(f'{1e3 * value:21.3f}' for value in arm)
        print(f'{name:<14}{1e3 * length:10.3f}{row}  {WrapState(wrap).name.lower()}')
    print(f'\ntotal {1e3 * state.total_length:.3f} mm, theta {state.theta:.6f} rad')


def play(args: argparse.Namespace) -> None:
    """Play a recording's joint states."""
    from .recordings import Recording

    recording = Recording.open(args.bag)
    length = 1e-9 * (recording.end - recording.start)
    if args.start_offset > length:
        raise ValueError(
            f'--start-offset: {args.start_offset:g} s given, the recording lasts {length:.1f} s'
        )
    from . import ros_environment

    ros_environment.prepare()
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    from .play import Pace
    from .play import play as play_recording

    pace = Pace(
        args.rate, args.loop, args.start_offset, args.clock or 0.0, args.wait, args.subscribers
    )
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    try:
        print(
            f'{recording.path}: {recording.count} joint states on {", ".join(recording.topics)}, '
            f'{length:.1f} s, at {args.rate:g} times its speed',
            flush=True,
        )
        count = play_recording(recording, pace)
        print(f'{count} joint states published')
    finally:
        rclpy.try_shutdown()


def process(args: argparse.Namespace) -> None:
    """Write recordings again, with the muscle's state beside the motion."""
    from . import process as work
    from . import workers
    from .frames import Bones

    if args.rhythm is not None and args.thorax is None:
        raise ValueError('--rhythm: for angles against the thorax alone (--thorax)')
    if (args.humerus is None) != (args.scapula is None and args.thorax is None):
        raise ValueError('--humerus NAME goes with --scapula NAME or --thorax NAME')
    if '' in (args.humerus, args.scapula, args.thorax):
        raise ValueError('--humerus, --scapula, --thorax: a name expected')
    bones = args.humerus and Bones(
        args.humerus, args.scapula, args.thorax, args.frame_axes, args.rhythm or 2.0
    )
    if args.thorax is not None:
        print(f'angles against the thorax: the scapula takes 1 part of an elevation to '
              f'{bones.rhythm:g} of the humerus (--rhythm), an assumption')  # fmt: skip
    options = {
        'bones': bones,
        'kind': args.format,
        'muscle': args.muscle,
        'side': args.side,
        'convention': args.convention,
        'joints': tuple(args.joints or ()),
        'signs': tuple(args.signs),
        'offsets': tuple(args.offsets),
        'degrees': True if args.degrees else None,
        'topic': args.topic,
        'frame_id': args.frame_id,
        'rate': args.rate,
        'lowpass': args.lowpass,
        'markers': args.markers,
        'force': args.force,
    }
    inputs = [found for each in args.inputs for found in work.matching(each)]
    tasks = work.tasks(inputs, Path(args.out), **options)
    if len(tasks) > 1 or tasks[0].target.parent == Path(args.out):
        try:
            Path(args.out).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ValueError(f'{args.out}: no folder to write into: {error.strerror}') from None
    failed = 0
    with bar() as shown, ended_like_interrupted():
        for report in workers.run_all(tasks, args.jobs, args.dask, shown):
            failed += bool(report.fault)
            tell(report)
    if len(tasks) > 1:
        print(f'{len(tasks) - failed} of {len(tasks)} recordings processed into {args.out}')
    if failed:
        raise SystemExit(1)


def plot(args: argparse.Namespace) -> None:
    """Draw a processed recording: lengths, moment arms and wrap states."""
    from .plot import save
    from .process import plain_name
    from .processed import read

    source = Path(args.output) if Path(args.output).name else Path(args.output).resolve()
    out = Path(args.out) if args.out else source.with_name(plain_name(source))
    processed = read(source)
    for kind in args.kinds or ['png']:
        for path in save(processed, out, kind):
            print(path)


def tell(report: Report) -> None:
    """Print what has become of a recording: a line, and one for each kind of refused frame."""
    task = report.task
    if report.fault:
        print(f'linkedplane: {report.fault}', file=sys.stderr)
        return
    refused = sum(report.refused.values())
    rate = report.frames / max(report.seconds, 1e-9)
    line = f'{task.source} -> {task.target}: {report.frames:,} frames, {rate:,.0f} a second'
    if refused:
        line += f', {refused:,} refused'
    if report.outside:
        line += f", {report.outside:,} outside the model's range of motion"
    print(line)
    for reason, count in report.refused.items():
        print(f'  {count:,} refused as {reason}, first at {report.first[reason]}')


@contextmanager
def ended_like_interrupted() -> Iterator[None]:
    """While in the block, SIGTERM ends it as SIGINT does: nothing half-written stays."""

    def end(*_: object) -> None:
        raise SystemExit(143)

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextmanager
def bar() -> Iterator[Callable[[int, float], None]]:
    """Show what is done while in the block, if a person looks on; give what is told of it."""
    try:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            Progress,
            TaskProgressColumn,
            TextColumn,
            TimeRemainingColumn,
        )
    except ImportError:
        yield lambda frames, share: None
        return
    columns = (
        BarColumn(),
        TaskProgressColumn(),
        TextColumn('{task.fields[frames]:,} frames'),
        TimeRemainingColumn(elapsed_when_finished=True),
    )
    with Progress(*columns, transient=True, disable=not sys.stderr.isatty(),
                  console=Console(stderr=True)) as progress:  # fmt: skip
        number = progress.add_task('', total=1.0, frames=0)
        yield lambda frames, share: progress.update(number, completed=share, frames=frames)


def positive(text: str) -> float:
    """Return a number above zero, for argparse."""
    value = float(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f'{text} given, a number > 0 expected')
    return value


def not_negative(text: str) -> float:
    """Return a finite number of zero or more, for argparse."""
    value = float(text)
    if not 0.0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f'{text} given, a number >= 0 expected')
    return value


def sign(text: str) -> float:
    """Return 1.0 or -1.0, for argparse."""
    value = float(text)
    if abs(value) != 1.0:
        raise argparse.ArgumentTypeError(f'{text} given, 1 or -1 expected')
    return value


def counting(text: str) -> int:
    """Return a whole number of one or more, for argparse."""
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f'{text} given, 1 or more expected')
    return value


def parser() -> argparse.ArgumentParser:
    """Return the command line's parser."""
    top = argparse.ArgumentParser(
        prog='linkedplane', description='Muscle paths by linked-plane obstacle sets.'
    )
    top.add_argument('--version', action='version', version=__version__)
    commands = top.add_subparsers(title='commands', required=True, metavar='COMMAND')

    def command(name: str, run: Callable[[argparse.Namespace], None]) -> argparse.ArgumentParser:
        made = commands.add_parser(name, help=run.__doc__, description=run.__doc__)
        made.set_defaults(run=run)
        return made

    one = command('info', info)
    one.add_argument('muscle', nargs='?', default='deltoid', metavar='MUSCLE',
                     help='a bundled model or a .yaml file (default: deltoid)')  # fmt: skip

    one = command('solve', solve)
    one.add_argument('--convention', choices=tuple(JOINT_CONVENTIONS), required=True,
                     help='what the angles mean')  # fmt: skip
    one.add_argument('angles', nargs=3, type=float, metavar='ANGLE',
                     help="the convention's three angles, rad")  # fmt: skip
    one.add_argument('--degrees', action='store_true', help='the angles are in degrees')
    one.add_argument('--side', choices=SIDES, default='right')
    one.add_argument('--muscle', default='deltoid', help='a bundled model or a .yaml file')
    one.add_argument('--json', action='store_true', help='print JSON, in m and rad')

    one = command('play', play)
    one.add_argument('bag', metavar='BAG', help='a rosbag2: folder, .mcap or .db3 file')
    one.add_argument('--rate', type=positive, default=1.0, help='times its own speed')
    one.add_argument('--loop', action='store_true', help='start anew at the end, until interrupted')
    one.add_argument('--clock', type=positive, nargs='?', const=40.0, metavar='HZ',
                     help='publish the recorded time on /clock (default 40 Hz)')  # fmt: skip
    one.add_argument('--start-offset', type=not_negative, default=0.0, metavar='S',
                     help='begin S seconds into the recording')  # fmt: skip
    one.add_argument('--wait', type=not_negative, default=10.0, metavar='S',
                     help='wait for a subscriber, S seconds at most (default 10)')  # fmt: skip
    one.add_argument('--subscribers', type=counting, default=1, metavar='N',
                     help='how many subscribers to wait for (default 1)')  # fmt: skip

    one = command('process', process)
    one.add_argument('inputs', nargs='+', metavar='INPUT',
                     help='bags, .mot, .sto or .csv files, or folders of them')  # fmt: skip
    one.add_argument('out', metavar='OUT',
                     help='a bag, .csv or .parquet; a folder for several inputs')  # fmt: skip
    one.add_argument('--format', choices=('bag', 'csv', 'parquet'),
                     help='of the output (default: by its ending; bag)')  # fmt: skip
    one.add_argument('--convention', choices=tuple(JOINT_CONVENTIONS),
                     default='flexion_abduction_rotation', help='what the angles mean')  # fmt: skip
    one.add_argument('--joints', nargs=3, metavar='NAME',
                     help="the three joints or columns (default: the convention's)")  # fmt: skip
    one.add_argument('--signs', nargs=3, type=sign, default=(1.0, 1.0, 1.0), metavar='SIGN',
                     help='angle = sign * recorded + offset')  # fmt: skip
    one.add_argument('--offsets', nargs=3, type=float, default=(0.0, 0.0, 0.0), metavar='RAD')
    one.add_argument('--degrees', action='store_true', help="the table's angles are in degrees")
    one.add_argument('--topic', help="the bag's topic of joint states, where it has several")
    one.add_argument('--humerus', metavar='NAME',
                     help='take poses for angles: a topic, or a frame in /tf')  # fmt: skip
    base = one.add_mutually_exclusive_group()
    base.add_argument('--scapula', metavar='NAME', help='what the humerus is measured against')
    base.add_argument('--thorax', metavar='NAME',
                      help='the same, less the share of the scapula (--rhythm)')  # fmt: skip
    one.add_argument('--rhythm', type=positive, metavar='RATIO',
                     help='glenohumeral to scapulothoracic elevation (default 2)')  # fmt: skip
    one.add_argument('--frame-axes', choices=('model', 'isb'), default='model',
                     help='of their frames; isb: x anterior, y superior, z lateral')  # fmt: skip
    one.add_argument('--side', choices=SIDES, default='right')
    one.add_argument('--muscle', default='deltoid', help='a bundled model or a .yaml file')
    one.add_argument('--frame-id', default='scapula', help='the frame of the outputs')
    one.add_argument('--rate', type=positive, metavar='HZ', help='resample the angles')
    one.add_argument('--lowpass', type=positive, metavar='HZ',
                     help='filter the angles first, without lag (Butterworth)')  # fmt: skip
    one.add_argument('--no-markers', dest='markers', action='store_false',
                     help='leave the markers out of a bag')  # fmt: skip
    one.add_argument('--force', action='store_true', help='replace an output that exists')
    one.add_argument('--jobs', type=counting, default=1, metavar='N',
                     help='recordings at a time (default 1)')  # fmt: skip
    one.add_argument('--dask', metavar='ADDRESS', help='work on a Dask cluster')

    one = command('plot', plot)
    one.add_argument('output', metavar='OUTPUT', help='what `linkedplane process` has written')
    one.add_argument('--png', dest='kinds', action='append_const', const='png',
                     help='draw PNG files (the default)')  # fmt: skip
    one.add_argument('--svg', dest='kinds', action='append_const', const='svg',
                     help='draw SVG files')  # fmt: skip
    one.add_argument('--out', metavar='NAME', help="the beginning of the files' names")
    return top


def plain(argument: str) -> str:
    """Return an argument, -1e-3 as -0.001: argparse takes the former for an option."""
    if re.fullmatch(r'-\d*\.?\d+[eE][-+]?\d+', argument):
        return f'{Decimal(argument):f}'
    return argument


def main(args: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status."""
    options = parser().parse_args([plain(arg) for arg in (sys.argv[1:] if args is None else args)])
    try:
        options.run(options)
        sys.stdout.flush()
    except ValueError as error:
        print(f'linkedplane: {error}', file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # whoever read the output has enough of it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
