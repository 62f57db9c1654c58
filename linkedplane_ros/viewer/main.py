# SPDX-License-Identifier: Apache-2.0
"""The executable muscle_viewer: its arguments, its port, its shutdown."""

from __future__ import annotations

import argparse
import contextlib
import errno
import io
import os
import socket
import subprocess
import sys
from threading import Thread

import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.executors import ExternalShutdownException

from ..libraries import advise_install
from ..node.ros_arguments import (
    argument_errors,
    check_ros_arguments,
    initialise_ros,
    warn_of_unknown_parameters,
)
from .arguments import LOOPBACK, PORT, parse_arguments
from .guard import WILDCARDS, Guard

REPORTED = 5.0  # s between lines of what browsers sent in vain
TRIED = 20  # ports above a busy one
NODE = [
    sys.executable,
    '-m',
    'linkedplane_ros.node',
    '--ros-args',
    '-p',
    'markers.rate:=120',
]


def find_port(host: str, port: int | None) -> int:
    """Return the port to listen on; SystemExit with one line if there is none."""
    first = PORT if port is None else port
    if not 0 <= first <= 65535:
        sys.exit(f'muscle_viewer: --port {port}: 0 to 65535 expected')
    for candidate in range(first, first + (TRIED if port is None else 1)):
        try:
            with socket.create_server((host, candidate)):
                pass
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                continue
            sys.exit(f'muscle_viewer: cannot listen on {host}:{candidate}: {error.strerror}')
        if candidate != first:
            print(f'muscle_viewer: port {first} is taken; --port chooses another', flush=True)
        return candidate
    sys.exit(f'muscle_viewer: port {first} is taken; --port chooses another')


def main(given: list[str] | None = None) -> None:
    """Serve until interrupted or terminated; both end it with status 0."""
    given = sys.argv if given is None else given
    options = parse_arguments(given)
    try:
        import viser
    except ImportError:
        sys.exit(f'muscle_viewer: viser is not installed: {advise_install("viser")}')
    from .app import Viewer
    from .node import ViewerNode

    port = find_port(options.host, options.port)
    if options.node:
        os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    check_ros_arguments(options.ros_arguments)
    initialise_ros([] if options.node else options.ros_arguments)
    with argument_errors():
        node = ViewerNode(options.topics, options.take)
    warn_of_unknown_parameters(node)
    guard = Guard(
        options.host,
        lambda line: node.get_logger().warning(line, throttle_duration_sec=REPORTED),
    )
    quiet = contextlib.redirect_stdout(io.StringIO())
    with quiet, guard.guard_server():
        server = viser.ViserServer(options.host, port, label='muscle viewer', verbose=False)
    guard.set_server(server)
    muscle = subprocess.Popen(node_command(options)) if options.node else None
    print(address_line(options.host, server.get_port(), guard.token), flush=True)
    reading = Thread(target=node.spin, args=(rclpy.ok,), daemon=True)
    reading.start()
    try:
        Viewer(server, node).run(
            lambda: rclpy.ok() and reading.is_alive() and not (muscle and muscle.poll())
        )
        if muscle and muscle.poll():  # it has said why
            sys.exit(muscle.returncode)
        if rclpy.ok():
            sys.exit(
                'muscle_viewer: the thread that reads the topics has ended; see the error above'
            )
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RCLError:
        if rclpy.ok():
            raise
    finally:
        rclpy.try_shutdown()
        reading.join(2.0)
        with quiet:
            server.stop()
        if muscle is not None:
            muscle.terminate()
            muscle.wait(10.0)


def node_command(options: argparse.Namespace) -> list[str]:
    """Return the command that starts the muscle's node, which listens to the viewer's topic."""
    listening = ['--ros-args', '-r', f'joint_states:={options.topics[0]}']
    return [*NODE, *options.ros_arguments, *listening]  # of two rules for a name the first holds


def address_line(host: str, port: int, token: str) -> str:
    """Return a line that says where the viewer is, and who can reach it."""
    name = LOOPBACK if host in WILDCARDS else host
    if host in (LOOPBACK, 'localhost', '::1'):
        reach = 'from this machine only; --host 0.0.0.0 lets others in'
    else:
        reach = 'from everywhere: everyone who has this address can see the arm and move it'
    return f'muscle_viewer: open http://{name}:{port}/?token={token} ({reach})'
