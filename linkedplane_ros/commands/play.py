# SPDX-License-Identifier: Apache-2.0
"""`linkedplane play`: a recording's joint states on a ROS topic."""

from __future__ import annotations

import argparse
import sys

from ..errors import LinkedPlaneError
from .argument_types import non_negative_number, positive_count, positive_number


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the command takes."""
    # fmt: off
    add = parser.add_argument
    add('bag', metavar='BAG', help='a rosbag2: folder, .mcap or .db3 file')
    add('--rate', type=positive_number, default=1.0, metavar='FACTOR',
        help='times the recorded speed (default: %(default)s)')
    add('--loop', action='store_true', help='start again at the end, until interrupted')
    add('--clock', type=positive_number, nargs='?', const=40.0, metavar='HZ',
        help='publish the recorded time on /clock (HZ left out: %(const)s)')
    add('--start-offset', type=non_negative_number, default=0.0, metavar='S',
        help='begin S seconds into the recording (default: %(default)s)')
    add('--wait', type=non_negative_number, default=10.0, metavar='S',
        help='wait for a subscriber, S seconds at most (default: %(default)s)')
    add('--subscribers', type=positive_count, default=1, metavar='N',
        help='how many subscribers to wait for (default: %(default)s)')
    # fmt: on


def run(args: argparse.Namespace) -> None:
    """Play a recording's joint states."""
    from ..recordings.bags.recording import Recording

    recording = Recording.from_bag(args.bag)
    for fault in recording.faults:
        print(f'linkedplane: warning: {recording.path}: {fault}', file=sys.stderr)
    length = 1e-9 * (recording.end - recording.start)
    if args.start_offset > length:
        raise LinkedPlaneError(
            f'--start-offset: {args.start_offset:g} s given, the recording lasts {length:.1f} s'
        )
    from ..node import environment

    environment.prepare()
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    from ..node.play import Playback, play_recording
    from ..node.ros_arguments import initialise_ros

    how = Playback(
        args.rate, args.loop, args.start_offset, args.clock or 0.0, args.wait, args.subscribers
    )
    initialise_ros(args.ros_arguments, signal_handler_options=SignalHandlerOptions.NO)
    try:
        print(
            f'{recording.path}: {recording.count} joint states on {", ".join(recording.topics)}, '
            f'{length:.1f} s, at {args.rate:g} times its speed',
            flush=True,
        )
        count = play_recording(recording, how)
        print(f'{count} joint states published')
    finally:
        rclpy.try_shutdown()
