# SPDX-License-Identifier: Apache-2.0
"""Many recordings at a time."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from multiprocessing import active_children
from pathlib import Path

import pytest
from bags import odd_motion, refusal_line, write_bag
from optional import requires
from unhurried import PATIENCE

from linkedplane_ros.processing.task import Task
from linkedplane_ros.processing.workers import Worker, run_tasks

PROCESS = [sys.executable, '-m', 'linkedplane_ros.commands', 'process']


def test_the_results_do_not_depend_on_how_many_work_at_a_time(tmp_path: Path) -> None:
    sources = [write_bag(tmp_path / f'in{k}', odd_motion()[: 20 + 2 * k]) for k in range(4)]
    for jobs in (1, 2):
        (tmp_path / str(jobs)).mkdir()
        made = [Task(s, tmp_path / str(jobs) / f'{s.name}.csv') for s in sources]
        reports = list(run_tasks(made, jobs, None))
        assert all(not report.fault for report in reports)
    for s in sources:
        one, two = (tmp_path / str(jobs) / f'{s.name}.csv' for jobs in (1, 2))
        assert one.read_bytes() == two.read_bytes()


@requires('distributed')
def test_a_cluster_gives_what_one_process_gives(tmp_path: Path) -> None:
    from dask import distributed

    sources = [write_bag(tmp_path / f'in{k}', odd_motion()[: 20 + 2 * k]) for k in range(3)]
    for place in ('here', 'there'):
        (tmp_path / place).mkdir()
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        for place, address in (('here', None), ('there', cluster.scheduler_address)):
            made = [Task(s, tmp_path / place / f'{s.name}.csv') for s in sources]
            reports = list(run_tasks(made, 1, address))
            assert [report.fault for report in reports] == [''] * 3
    for s in sources:
        here, there = (tmp_path / place / f'{s.name}.csv' for place in ('here', 'there'))
        assert here.read_bytes() == there.read_bytes()


@requires('distributed')
def test_a_cluster_that_is_not_there_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    line = refusal_line(capsys, str(source), str(tmp_path / 'x'), '--dask', 'tcp://127.0.0.1:9')
    assert '--dask tcp://127.0.0.1:9: not reached' in line


def long_recordings(tmp_path: Path, count: int, frames: int = 15_000) -> list[Path]:
    """Write recordings that take a while."""
    lines = ['time,flexion,abduction,rotation']
    lines += [f'{0.01 * k:.2f},{0.5 + 0.4 * math.sin(0.01 * k)},0.3,0.1' for k in range(frames)]
    text = '\n'.join(lines) + '\n'
    made = [tmp_path / f'in{k}.csv' for k in range(count)]
    for path in made:
        path.write_text(text)
    return made


def children(process: int) -> list[int]:
    """Return the processes that a process has started."""
    found = []
    for task in Path(f'/proc/{process}/task').iterdir():
        found += [int(each) for each in (task / 'children').read_text().split()]
    return found


def alive(process: int) -> bool:
    """Return whether a process is more than an entry in a table."""
    try:
        return Path(f'/proc/{process}/cmdline').read_bytes() != b''
    except OSError:
        return False


needs_proc = pytest.mark.skipif(not Path('/proc/self/task').exists(), reason='no /proc here')


def parts(folder: Path) -> list[Path]:
    """Return what is being written."""
    return list(folder.glob('.*.part'))


def is_writing(process: int) -> bool:
    """Return whether a process has a folder open in which an output is written."""
    try:
        return any('.part' in os.readlink(each) for each in Path(f'/proc/{process}/fd').iterdir())
    except OSError:  # closed while we look
        return False


@needs_proc
def test_a_worker_that_dies_costs_its_recording_alone(tmp_path: Path) -> None:
    sources = long_recordings(tmp_path, 3)
    (tmp_path / 'out').mkdir()
    made = [Task(source, tmp_path / 'out' / f'{k}.csv') for k, source in enumerate(sources)]
    reports = run_tasks(made, 2, None)
    with ThreadPoolExecutor(1) as pool:
        collected = pool.submit(list, reports)
        writing: list[int] = []
        while not writing:
            workers = [each.pid for each in active_children() if each.pid is not None]
            writing = list(filter(is_writing, workers))
        os.kill(writing[0], signal.SIGKILL)
        done = collected.result()
    faults = [report.fault for report in done if report.fault]
    assert len(done) == 3
    assert [fault.partition(': ')[2] for fault in faults] == ['its process died, status -9']
    assert len(list((tmp_path / 'out').iterdir())) == 2  # and no .part


@pytest.mark.parametrize('when', ['before', 'after'])
def test_a_worker_may_die_before_it_has_read_its_task(
    tmp_path: Path, when: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    begin = Worker.begin

    def begin_and_die(worker: Worker, number: int, task: Task) -> None:
        if number == 0 and when == 'before':
            worker.process.kill()
            worker.process.join()
        begin(worker, number, task)
        if number == 0:
            worker.process.kill()

    monkeypatch.setattr(Worker, 'begin', begin_and_die)
    made = [
        Task(write_bag(tmp_path / f'in{k}', odd_motion()), tmp_path / f'{k}.csv') for k in (0, 1)
    ]
    reports = {report.task.source.name: report.fault for report in run_tasks(made, 2, None)}
    assert reports == {'in0': f'{tmp_path / "in0"}: its process died, status -9', 'in1': ''}


@needs_proc
@pytest.mark.parametrize('jobs', ['1', '2'])
@pytest.mark.parametrize(('number', 'status'), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interruption_ends_all_workers_and_leaves_nothing_half_written(
    tmp_path: Path, jobs: str, number: signal.Signals, status: int
) -> None:
    sources = long_recordings(tmp_path, 2, 200_000)
    out = tmp_path / 'out'
    command = [
        sys.executable,
        '-m',
        'linkedplane_ros.commands',
        'process',
        *map(str, sources),
        str(out),
    ]
    with subprocess.Popen(
        [*command, '--format', 'csv', '--jobs', jobs], stderr=subprocess.PIPE, text=True
    ) as process:
        while not out.exists() or len(parts(out)) < int(jobs):
            time.sleep(0.01)
            assert process.poll() is None
        begun = children(process.pid)
        process.send_signal(number)
        assert process.communicate(timeout=PATIENCE)[1] == ''
    assert process.returncode == status
    assert list(out.iterdir()) == []
    until = time.monotonic() + PATIENCE
    while any(alive(each) for each in begun):
        assert time.monotonic() < until
        time.sleep(0.05)


@pytest.mark.parametrize('jobs', [1, 2])
def test_progress_goes_from_nothing_to_the_whole(tmp_path: Path, jobs: int) -> None:
    table, short = long_recordings(tmp_path, 2, 12_000)
    short.write_text('\n'.join(short.read_text().split('\n')[:2000]) + '\n')
    bag = write_bag(tmp_path / 'bag', odd_motion())
    made = [Task(each, tmp_path / f'out_{k}') for k, each in enumerate((table, short, bag))]
    seen: list[tuple[int, float]] = []
    reports = list(run_tasks(made, jobs, None, lambda frames, share: seen.append((frames, share))))
    assert [report.fault for report in reports] == ['', '', '']
    assert seen == sorted(seen)
    assert seen[-1] == (sum(report.frames for report in reports), pytest.approx(1.0))
    assert jobs > 1 or any(0.2 < share < 0.8 for _, share in seen)


@requires('pty', 'rich')
def test_on_a_terminal_the_lines_stand_alone_and_go_where_they_are_sent(tmp_path: Path) -> None:
    import pty

    sources = [write_bag(tmp_path / f'in{k}', odd_motion()) for k in range(2)]
    near, far = pty.openpty()
    command = [*PROCESS, *map(str, sources)]
    with (
        (tmp_path / 'log').open('w') as log,
        subprocess.Popen([*command, str(tmp_path / 'out')], stdout=log, stderr=far) as process,
    ):
        os.close(far)
        shown = b''
        with suppress(OSError):  # the end of a terminal
            while got := os.read(near, 4096):
                shown += got
    os.close(near)
    assert process.returncode == 0
    lines = (tmp_path / 'log').read_text().splitlines()
    assert sum(' a second' in line for line in lines) == 2
    assert lines[-1].startswith('2 of 2 recordings processed')
    assert b'100%' in shown
    assert b' a second' not in shown
