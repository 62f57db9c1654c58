# SPDX-License-Identifier: Apache-2.0
"""Many poses at a time: a kernel runs in threads if that pays."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy.typing as npt

from ..linked_planes.compilation import COMPILED
from ..types import Floats
from .kernels import SOLVED, Outcome

PARALLEL_FROM = 512  # poses: below this, threads cost more than they give
BLOCK = 1000  # poses that are lists at a time, uncompiled


def run_kernel(
    kernel: Callable[..., Outcome],
    given: tuple[Any, ...],
    poses: Floats,
    filled: tuple[npt.NDArray[Any], ...],
) -> Outcome:
    """Run a kernel over poses: in threads if that pays; on lists, which are faster, if uncompiled.

    Parameters
    ----------
    kernel
        Called with `given`, poses, the first pose and the one after the last, and `filled`.
    given
        What is the same at all poses.
    poses
        (m, 3, 3) humerus -> scapula, or (m, k, 3, 4) of k bones.
    filled
        Arrays (m, ...) that the kernel fills in.

    """
    m = len(poses)
    if not COMPILED:
        for start in range(0, m, BLOCK):
            part = slice(start, start + BLOCK)
            lists = [array[part].tolist() for array in filled]
            given_poses = poses[part].tolist()
            k, fault, band = kernel(*given, given_poses, 0, len(lists[0]), *lists)
            if fault != SOLVED:
                return start + k, fault, band
            for array, values in zip(filled, lists, strict=True):
                array[part] = values
        return m, SOLVED, 0
    threads = available_cores() if m >= PARALLEL_FROM else 1
    if threads == 1:
        return kernel(*given, poses, 0, m, *filled)
    bounds = [m * i // threads for i in range(threads + 1)]
    with ThreadPoolExecutor(threads) as pool:
        outcomes = pool.map(
            lambda start, stop: kernel(*given, poses, start, stop, *filled),
            bounds[:-1],
            bounds[1:],
        )
    return next((outcome for outcome in outcomes if outcome[1] != SOLVED), (m, SOLVED, 0))


def available_cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, 'sched_getaffinity'):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
