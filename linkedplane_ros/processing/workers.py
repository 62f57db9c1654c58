# SPDX-License-Identifier: Apache-2.0
"""Many recordings: one after the other, in processes of their own, or on a Dask cluster.

The results do not depend on how many are processed at a time.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import RecordingError
from ..files import claim_output
from ..libraries import advise_install
from .task import Progress, Report, Task, report_failure, run_task

# a fresh interpreter: threads and compiled code do not outlive a fork well
CONTEXT = get_context('spawn')
POLL_INTERVAL = 0.1  # s, between two looks at the progress of other processes
FRAMES, SHARE = range(2)  # what the board holds of each task


def run_tasks(
    tasks: Sequence[Task], jobs: int, dask: str | None, show: Progress = lambda frames, share: None
) -> Iterator[Report]:
    """Process recordings, and yield each report as it is complete.

    Parameters
    ----------
    tasks
        The recordings.
    jobs
        How many are processed at a time.
    dask
        The address of a Dask cluster; None: here.
    show
        Called with the frames of all recordings done so far, and their share by size, 0 to 1.

    Raises
    ------
    RecordingError
        If the cluster cannot be reached.
    """
    sizes = np.array([float(recording_size(task.source)) for task in tasks])
    board = CONTEXT.Array('d', 2 * len(tasks), lock=False)

    def show_all() -> None:
        done = np.array(board).reshape(-1, 2)
        show(int(done[:, FRAMES].sum()), float(done[:, SHARE] @ sizes / sizes.sum()))

    for number, report in run_numbered(tasks, jobs, dask, board, show_all):
        record_progress(board, number, report.frames, 1.0)
        show_all()
        yield report


def run_numbered(
    tasks: Sequence[Task], jobs: int, dask: str | None, board: Any, show: Callable[[], None]
) -> Iterator[tuple[int, Report]]:
    """Yield the number and the report of each task as it ends."""
    if dask is not None:
        yield from run_on_cluster(tasks, dask)
    elif min(jobs, len(tasks)) > 1:
        yield from run_in_processes(tasks, min(jobs, len(tasks)), board, show)
    else:
        for number, task in enumerate(tasks):

            def progress(frames: int, share: float, number: int = number) -> None:
                record_progress(board, number, frames, share)
                show()

            yield number, run_task(task, progress)


def recording_size(path: Path) -> int:
    """Return the bytes of a recording, 1 at least."""
    files = path.rglob('*') if path.is_dir() else (path,)
    with suppress(OSError):
        return max(1, sum(file.stat().st_size for file in files))
    return 1


def record_progress(board: Any, number: int, frames: int, share: float) -> None:
    """Write on the board how far a task is."""
    board[2 * number + FRAMES] = frames
    board[2 * number + SHARE] = share


class Worker:
    """A process for one recording after the other; if it dies, only the current one is lost."""

    def __init__(self, board: Any) -> None:
        """Start the process."""
        self.pipe, far = CONTEXT.Pipe()
        self.number = -1
        self.process = CONTEXT.Process(target=serve_tasks, args=(far, board), daemon=True)
        self.process.start()
        far.close()

    def begin(self, number: int, task: Task) -> None:
        """Give it a task; a dead process is noticed when its report is received."""
        self.number = number
        with suppress(OSError):
            self.pipe.send((number, task))

    def end(self) -> None:
        """End the process; it removes what it was writing."""
        self.process.terminate()
        self.process.join()


def serve_tasks(pipe: Any, board: Any) -> None:
    """Process tasks as they come, until the other end closes; it handles interruptions."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())
    with suppress(EOFError, OSError):
        while True:
            number, task = pipe.recv()
            pipe.send(run_task(task, partial(record_progress, board, number)))


def run_in_processes(
    tasks: Sequence[Task], jobs: int, board: Any, show: Callable[[], None]
) -> Iterator[tuple[int, Report]]:
    """Process `jobs` recordings at a time; an interruption ends them without partial outputs."""
    left = iter(enumerate(tasks))
    busy: dict[Any, Worker] = {}
    idle = [Worker(board) for _ in range(jobs)]
    try:
        while True:
            while idle and (following := next(left, None)) is not None:
                worker = idle.pop()
                worker.begin(*following)
                busy[worker.pipe] = worker
            if not busy:
                return
            ready: list[Any] = wait(list(busy), POLL_INTERVAL)
            for pipe in ready:
                worker = busy.pop(pipe)
                task = tasks[worker.number]
                try:
                    report: Report = pipe.recv()
                    idle.append(worker)
                except (EOFError, OSError):
                    worker.end()
                    with (
                        suppress(OSError, RecordingError),
                        claim_output(task.target, RecordingError),
                    ):
                        pass  # what it was writing is removed
                    code = worker.process.exitcode
                    report = Report(task, fault=f'{task.source}: its process died, status {code}')
                    idle.append(Worker(board))
                yield worker.number, report
            show()
    finally:
        for worker in (*idle, *busy.values()):
            worker.end()


def run_on_cluster(tasks: Sequence[Task], address: str) -> Iterator[tuple[int, Report]]:
    """Process recordings on a Dask cluster that sees the same files."""
    try:
        from dask.distributed import Client, as_completed
    except ImportError:
        raise RecordingError(f'a cluster needs Dask: {advise_install("dask")}') from None
    try:
        client = Client(address, timeout='10s')
    except (OSError, ValueError) as error:
        raise RecordingError(f'--dask {address}: not reached: {error}') from None
    with client:
        futures = {
            client.submit(run_task, make_absolute(task), pure=False): number
            for number, task in enumerate(tasks)
        }
        try:
            for future in as_completed(list(futures)):
                number = futures[future]
                try:
                    report = replace(future.result(), task=tasks[number])
                except Exception as error:
                    report = report_failure(tasks[number], error)
                yield number, report
        finally:
            client.cancel(list(futures))


def make_absolute(task: Task) -> Task:
    """Return a task with paths that hold in any folder."""
    options = task.options
    model = Path(options.muscle)
    if model.is_file():
        options = replace(options, muscle=str(model.resolve()))
    return Task(task.source.resolve(), task.target.resolve(), options)
