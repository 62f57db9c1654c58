# SPDX-License-Identifier: Apache-2.0
"""The executable muscle_viewer: its arguments, its port, its shutdown."""

from __future__ import annotations

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
        node = ViewerNode()
    warn_of_unknown_parameters(node)
    muscle = subprocess.Popen([*NODE, *options.ros_arguments]) if options.node else None
    quiet = contextlib.redirect_stdout(io.StringIO())
    with quiet:
        server = viser.ViserServer(options.host, port, label='muscle viewer', verbose=False)
    server.request_share_url = lambda verbose=True: None  # no request leaves this machine
    print(address_line(options.host, server.get_port()), flush=True)
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


def address_line(host: str, port: int) -> str:
    """Return a line that says where the viewer is, and who can reach it."""
    name = LOOPBACK if host in ('', '0.0.0.0', '::') else host
    if host in (LOOPBACK, 'localhost', '::1'):
        reach = 'from this machine only; --host 0.0.0.0 lets others in'
    else:
        reach = 'from everywhere: everyone who reaches this address can see the arm and move it'
    return f'muscle_viewer: open http://{name}:{port} ({reach})'
