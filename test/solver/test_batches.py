# SPDX-License-Identifier: Apache-2.0
"""Many poses at a time: in blocks of lists, in threads, or at once, to the same end."""

from __future__ import annotations

import os
import threading
from typing import Any

import numpy as np
import pytest

from linkedplane_ros.solver import batches
from linkedplane_ros.solver.batches import BLOCK, PARALLEL_FROM, available_cores, run_kernel
from linkedplane_ros.solver.kernels import SOLVED

FAULT = 3
SIZES = [0, 1, 5, PARALLEL_FROM - 1, PARALLEL_FROM, BLOCK, BLOCK + 1, 2 * BLOCK + 7]


class Doubling:
    """A kernel: twice and thrice what it is given, up to the first pose that is wrong."""

    def __init__(self, *wrong: int) -> None:
        self.wrong = wrong
        self.calls: list[tuple[int, int, Any]] = []
        self.threads: set[int] = set()

    def __call__(
        self, factor: float, given: Any, start: int, stop: int, twice: Any, thrice: Any
    ) -> tuple[int, int, int]:
        self.calls.append((start, stop, type(given)))
        self.threads.add(threading.get_ident())
        for k in range(start, stop):
            if int(given[k]) in self.wrong:
                return k, FAULT, 7
            twice[k], thrice[k][0] = 2.0 * factor * given[k], 3.0 * factor * given[k]
        return stop, SOLVED, 0


def run(kernel: Doubling, m: int) -> tuple[tuple[int, int, int], Any, Any]:
    """Run a kernel over m numbers; what it answers, and what it filled in."""
    given, filled = np.arange(m, dtype=float), (np.full(m, -1.0), np.full((m, 1), -1.0))
    return run_kernel(kernel, (10.0,), given, filled), *filled


@pytest.mark.parametrize('compiled', [False, True], ids=['lists', 'arrays'])
@pytest.mark.parametrize('cores', [1, 3])
@pytest.mark.parametrize('m', SIZES)
def test_every_pose_is_answered_in_its_place(
    monkeypatch: pytest.MonkeyPatch, compiled: bool, cores: int, m: int
) -> None:
    monkeypatch.setattr(batches, 'COMPILED', compiled)
    monkeypatch.setattr(batches, 'available_cores', lambda: cores)
    kernel = Doubling()
    outcome, twice, thrice = run(kernel, m)
    assert outcome == (m, SOLVED, 0)
    np.testing.assert_array_equal(twice, 20.0 * np.arange(m))
    np.testing.assert_array_equal(thrice[:, 0], 30.0 * np.arange(m))
    if compiled:
        parts = cores if m >= PARALLEL_FROM else 1
        assert len(kernel.calls) == parts
        sizes = [stop - start for start, stop, _ in kernel.calls]
        assert sum(sizes) == m
        assert max(sizes) - min(sizes) <= 1
        assert (threading.get_ident() in kernel.threads) == (parts == 1)
    else:
        assert all(kind is list and start == 0 for start, _, kind in kernel.calls)
        assert max((stop for _, stop, _ in kernel.calls), default=0) == min(m, BLOCK)
        assert len(kernel.calls) == -(-m // BLOCK)


@pytest.mark.parametrize('compiled', [False, True], ids=['lists', 'arrays'])
@pytest.mark.parametrize('wrong', [(0,), (4,), (1700, 2100), (BLOCK, 2500), (2500,)], ids=str)
def test_the_first_pose_without_an_answer_is_told(
    monkeypatch: pytest.MonkeyPatch, compiled: bool, wrong: tuple[int, ...]
) -> None:
    monkeypatch.setattr(batches, 'COMPILED', compiled)
    monkeypatch.setattr(batches, 'available_cores', lambda: 3)
    assert run(Doubling(*wrong), 2600)[0] == (wrong[0], FAULT, 7)


def test_the_cores_are_those_that_this_process_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    if hasattr(os, 'sched_getaffinity'):
        assert available_cores() == len(os.sched_getaffinity(0))
        monkeypatch.delattr(os, 'sched_getaffinity')
    monkeypatch.setattr(os, 'cpu_count', lambda: 6)
    assert available_cores() == 6
    monkeypatch.setattr(os, 'cpu_count', lambda: None)  # not known
    assert available_cores() == 1
