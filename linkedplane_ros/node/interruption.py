# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C while the node is built, which takes long where the solver is compiled.

rclpy's handlers only mark ROS as shut down, which is seen when the node spins.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread
from types import FrameType

from rclpy.signals import install_signal_handlers, uninstall_signal_handlers

ENDING = (signal.SIGINT, signal.SIGTERM)
RETRY = 0.2  # s


def end_on_hangup() -> None:
    """Let the end of the terminal end this process as SIGTERM does, unless nohup ignores it."""
    in_main = current_thread() is main_thread()
    if in_main and signal.getsignal(signal.SIGHUP) == signal.SIG_DFL:
        signal.signal(signal.SIGHUP, lambda *_: signal.raise_signal(signal.SIGTERM))


@contextmanager
def interruptible() -> Iterator[None]:
    """Raise KeyboardInterrupt inside when a signal asks the process to end, and so end the block.

    Python drops, with a traceback, what is raised in a callback of C code, as the compiler has
    them; so it is raised again until the block is left. rclpy must be initialised. It handles the
    signals again afterwards.
    """
    interrupted = left = False

    def interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal interrupted
        interrupted = True
        for each in (*ENDING, signal.SIGHUP):  # Ctrl-C reaches a launched node twice
            signal.signal(each, signal.SIG_IGN)
        if not left:
            signal.setitimer(signal.ITIMER_REAL, RETRY)
        raise KeyboardInterrupt

    def report_dropped(dropped: sys.UnraisableHookArgs) -> None:
        if not issubclass(dropped.exc_type, KeyboardInterrupt):
            report(dropped)

    uninstall_signal_handlers()
    hangup = () if signal.getsignal(signal.SIGHUP) == signal.SIG_IGN else (signal.SIGHUP,)
    taken = (*ENDING, *hangup, signal.SIGALRM)
    before = {each: signal.signal(each, interrupt) for each in taken}
    report, sys.unraisablehook = sys.unraisablehook, report_dropped
    try:
        yield
    finally:
        left = True
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        if interrupted:  # whatever has become of what was raised
            # Python's own mark that a text was interrupted while it was evaluated, as those of
            # namedtuple, would end the process by SIGINT after all; the next text clears it
            exec('')
            raise KeyboardInterrupt
        sys.unraisablehook = report
        for number, handler in before.items():
            signal.signal(number, handler)
        install_signal_handlers()
