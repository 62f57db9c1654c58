# SPDX-License-Identifier: Apache-2.0
"""How far a command is, for a person who watches it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any


class ProgressBar:
    """A bar on the terminal, while in the block; none if stderr is no terminal, or without rich.

    Parameters
    ----------
    total
        What `completed` is at the end.
    """

    def __init__(self, total: float = 1.0) -> None:
        """Prepare the bar; it is shown from the beginning of the block on."""
        self._bar: Any = None
        if not sys.stderr.isatty():
            return
        with suppress(ImportError):
            from rich.console import Console
            from rich.progress import (
                BarColumn,
                Progress,
                TaskProgressColumn,
                TextColumn,
                TimeRemainingColumn,
            )

            self._bar = Progress(
                BarColumn(),
                TaskProgressColumn(),
                TextColumn('{task.description}'),
                TimeRemainingColumn(elapsed_when_finished=True),
                transient=True,
                console=Console(stderr=True),
                redirect_stdout=False,
                redirect_stderr=False,
            )
            self._bar.add_task('', total=total)

    def __enter__(self) -> ProgressBar:
        """Show the bar."""
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Remove the bar."""
        if self._bar is not None:
            self._bar.stop()

    def update(self, completed: float, text: str) -> None:
        """Show how much of the total is completed, and a text beside it."""
        if self._bar is not None:
            self._bar.update(0, completed=completed, description=text)

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Remove the bar while the block prints lines."""
        self.__exit__()
        yield
        sys.stdout.flush()
        self.__enter__()
