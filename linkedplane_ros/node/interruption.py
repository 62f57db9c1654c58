# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C while the node is built, which takes long where the solver is compiled.

rclpy's handlers only mark ROS as shut down, which is seen when the node spins.
"""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from rclpy.signals import install_signal_handlers, uninstall_signal_handlers

ENDING = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def interruptible() -> Iterator[None]:
    """Raise KeyboardInterrupt inside when a signal asks the process to end; once.

    rclpy must be initialised. It handles the signals again afterwards.
    """
    interrupted = False

    def interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal interrupted
        interrupted = True
        for each in ENDING:  # Ctrl-C reaches a launched node twice
            signal.signal(each, signal.SIG_IGN)
        raise KeyboardInterrupt

    uninstall_signal_handlers()
    before = {number: signal.signal(number, interrupt) for number in ENDING}
    try:
        yield
        if interrupted:  # Python drops what is raised in a callback of C code
            raise KeyboardInterrupt
    finally:
        if not interrupted:
            for number, handler in before.items():
                signal.signal(number, handler)
            install_signal_handlers()
