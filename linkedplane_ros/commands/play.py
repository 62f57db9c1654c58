"""`linkedplane play`: a recording's joint states on a ROS topic."""

from __future__ import annotations

import argparse

from .values import counting, not_negative, positive


def arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the command takes."""
    parser.add_argument('bag', metavar='BAG', help='a rosbag2: folder, .mcap or .db3 file')
    parser.add_argument('--rate', type=positive, default=1.0, help='times its own speed')
    parser.add_argument(
        '--loop', action='store_true', help='start anew at the end, until interrupted'
    )
    parser.add_argument('--clock', type=positive, nargs='?', const=40.0, metavar='HZ',
                     help='publish the recorded time on /clock (default 40 Hz)')  # fmt: skip
    parser.add_argument('--start-offset', type=not_negative, default=0.0, metavar='S',
                     help='begin S seconds into the recording')  # fmt: skip
    parser.add_argument('--wait', type=not_negative, default=10.0, metavar='S',
                     help='wait for a subscriber, S seconds at most (default 10)')  # fmt: skip
    parser.add_argument('--subscribers', type=counting, default=1, metavar='N',
                     help='how many subscribers to wait for (default 1)')  # fmt: skip


def run(args: argparse.Namespace) -> None:
    """Play a recording's joint states."""
    from ..recordings.bags import Recording

    recording = Recording.open(args.bag)
    length = 1e-9 * (recording.end - recording.start)
    if args.start_offset > length:
        raise ValueError(
            f'--start-offset: {args.start_offset:g} s given, the recording lasts {length:.1f} s'
        )
    from ..node import environment

    environment.prepare()
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    from ..node.play import Pace
    from ..node.play import play as play_recording

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
