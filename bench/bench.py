# SPDX-License-Identifier: Apache-2.0
"""Measure the solver beside its rivals, everything in one run: a table, and build/bench.json.

`make bench` runs it. Times are the best of many rounds: the machine's noise only adds.
"""

from __future__ import annotations

import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import criterion
import numpy as np
import recordings

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.drawing.markdown import markdown_table
from linkedplane_ros.joints.conventions import THESIS_CONVENTION
from linkedplane_ros.linked_planes.compilation import COMPILED
from linkedplane_ros.rivals.cost import best_times
from linkedplane_ros.solver import linked_plane_solver as solver

POSE = np.array((0.5, 0.4, 0.2))  # rad
HERE = Path(__file__).parent
FIRST_ANSWER = (
    'import numpy, linkedplane_ros as l; '
    "l.LinkedPlaneSolver(l.BroadMuscle.load('deltoid')).solve(numpy.eye(3))"
)


def random_rotations(count: int) -> np.ndarray:
    """Return random rotations: flexion -40..120, abduction 0..120, rotation +-60 deg."""
    rng = np.random.default_rng(1)
    angles = np.radians(rng.uniform((-40, 0, -60), (120, 120, 60), (min(count, 5000), 3)))
    rotations = np.array([THESIS_CONVENTION.rotation(each) for each in angles])
    return np.resize(rotations, (count, 3, 3))


def broaden_deltoid(bands: int) -> BroadMuscle:
    """Return the deltoid with another number of bands: the same fan in more planes."""
    muscle = BroadMuscle.load('deltoid')
    n = len(muscle.band_names)
    old, new = np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, bands)

    def spread(values: np.ndarray) -> np.ndarray:
        columns = values.reshape(n, -1).T
        return np.column_stack([np.interp(new, old, column) for column in columns])

    return replace(
        muscle,
        band_names=tuple(f'band_{i}' for i in range(bands)),
        heads=(),
        origins=spread(muscle.origins),
        insertions=spread(muscle.insertions),
        sphere_centres=spread(muscle.sphere_centres),
        sphere_radii=spread(muscle.sphere_radii).ravel(),
        plane_angles=spread(muscle.plane_angles).ravel() * (n - 1) / (bands - 1),
    )


def measure_rates(batches: Mapping[str, tuple[BroadMuscle, int, int]]) -> dict[str, float]:
    """Return frames a second of solve_batch for each muscle, number of frames and of cores."""

    def batch(muscle: BroadMuscle, frames: int, cores: int) -> Callable[[], Any]:
        one, rotations = LinkedPlaneSolver(muscle), random_rotations(frames)

        def call() -> None:
            solver.available_cores = lambda: cores
            one.solve_batch(rotations)

        return call

    cores_before = solver.available_cores
    try:
        times = best_times({name: batch(*each) for name, each in batches.items()})
    finally:
        solver.available_cores = cores_before
    return {name: frames / times[name] for name, (_, frames, _) in batches.items()}


def measure_batch_memory(frames: int) -> float:
    """Return the peak memory of solve_batch beyond its inputs and outputs, MiB."""
    code = (
        'import bench, pathlib\n'
        'def status(name):\n'
        "    lines = pathlib.Path('/proc/self/status').read_text().splitlines()\n"
        '    return next(int(l.split()[1]) for l in lines if l.startswith(name)) / 1024\n'
        "one = bench.LinkedPlaneSolver(bench.BroadMuscle.load('deltoid'))\n"
        f'rotations = bench.random_rotations({frames})\n'
        'one.solve_batch(rotations[:1000])\n'
        "pathlib.Path('/proc/self/clear_refs').write_text('5')\n"
        "before = status('VmRSS')\n"
        'batch = one.solve_batch(rotations)\n'
        'kept = (batch.theta, batch.lengths, batch.moment_vectors, batch.wrap, batch.rotation)\n'
        "print(status('VmHWM') - before - sum(each.nbytes for each in kept) / 2**20)\n"
    )
    return float(run_python(code))


def run_python(code: str, **environment: str) -> str:
    """Run Python code, or a file of it, in a new process; return what it prints."""
    run = subprocess.run(
        [sys.executable, *([code] if code.endswith('.py') else ['-c', code])],
        env={
            **os.environ,
            'PYTHONPATH': os.pathsep.join((str(HERE), *sys.path[1:])),
            **environment,
        },
        check=True,
        capture_output=True,
        text=True,
    )
    return run.stdout.strip()


def measure_start_up(rounds: int, **environment: str) -> float:
    """Return s from the start of a process to its first answer."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        run_python(FIRST_ANSWER, **environment)
        times.append(time.perf_counter() - start)
    return min(times)


def other_engines(one: LinkedPlaneSolver) -> tuple[dict[str, Callable[[], Any]], dict[str, str]]:
    """Return MuJoCo's and OpenSim's calls for nine unlinked bands, and why any are left out."""
    from rivals import MujocoBands, OpenSimBands

    muscle = one.muscle
    centres = one.solve(np.eye(3)).sphere_centres
    given = (muscle.origins, muscle.insertions, centres, muscle.sphere_radii)
    calls: dict[str, Callable[[], Any]] = {}
    missing = {}
    try:
        mujoco = MujocoBands(*given)
        mujoco.set_pose(THESIS_CONVENTION.rotation(POSE))
        calls['mujoco'] = mujoco.update
    except ImportError as error:
        missing['mujoco'] = f'left out: {error}'
    try:
        opensim = OpenSimBands(*given)
        calls['opensim'] = lambda: opensim.solve(POSE)
    except ImportError as error:
        missing['opensim'] = f'left out: {error}'
    return calls, missing


def measure() -> dict[str, Any]:
    """Return every figure, in s, frames a second and MiB."""
    one = LinkedPlaneSolver(BroadMuscle.load('deltoid'))
    rotation = THESIS_CONVENTION.rotation(POSE)
    figures: dict[str, Any] = {'machine': describe_machine(), 'compiled': COMPILED}
    calls, missing = other_engines(one)
    figures.update(best_times({'call': lambda: one.solve(rotation), **calls}), **missing)
    figures.update(best_times(criterion.criterion_calls(one)))
    figures['call uncompiled'] = float(
        run_python(
            'import bench; one = bench.LinkedPlaneSolver(bench.BroadMuscle.load("deltoid"))\n'
            'rotation = bench.THESIS_CONVENTION.rotation(bench.POSE)\n'
            "print(bench.best({'call': lambda: one.solve(rotation)})['call'])",
            LINKEDPLANE_COMPILE='0',
        )
    )
    two = min(2, solver.available_cores())
    figures['frames'] = measure_rates(
        {
            f'{frames:,} frames, {used} core{"s" * (used > 1)}': (one.muscle, frames, used)
            for frames in (100, 1_000, 10_000, 100_000)
            for used in range(1, two + 1)
        }
    )
    figures['bands'] = measure_rates(
        {f'{n} bands, 2,000 frames': (broaden_deltoid(n), 2_000, two) for n in (9, 90, 900)}
    )
    figures['batch memory'] = {str(m): measure_batch_memory(m) for m in (100_000, 400_000)}
    figures['start cached'] = measure_start_up(5)
    with tempfile.TemporaryDirectory() as empty:
        figures['start cold'] = measure_start_up(1, NUMBA_CACHE_DIR=empty)
    figures['start uncompiled'] = measure_start_up(5, LINKEDPLANE_COMPILE='0')
    figures['recordings'] = recordings.measure()
    figures['latency'] = json.loads(run_python(str(HERE / 'latency.py')))
    figures['viewer'] = json.loads(run_python(str(HERE / 'viewer.py')))
    return figures


def describe_machine() -> str:
    """Return the processor's name and the number of cores in use."""
    try:
        lines = Path('/proc/cpuinfo').read_text().splitlines()
        name = next(line.partition(': ')[2] for line in lines if line.startswith('model name'))
    except (OSError, StopIteration):
        name = platform.processor() or platform.machine()
    return f'{name}, {solver.available_cores()} cores, Python {platform.python_version()}'


def format_table(figures: dict[str, Any]) -> str:
    """Return the figures as the documentation has them (doc/explanation/speed.md)."""
    call = figures['call']
    rows = [
        ('lengths + 9x3 moment vectors, one call', f'{1e6 * call:.1f} us', ''),
        ('the same, uncompiled', f'{1e3 * figures["call uncompiled"]:.2f} ms', ''),
    ]
    for name, title, ratio in (
        ('mujoco', "MuJoCo's 9 unlinked tendons + Jacobian", 'ours takes {:.1f} times as long'),
        ('opensim', "OpenSim's 9 WrapSpheres + 3 moment arms", 'ours is {:.0f} times faster'),
    ):
        value = figures[name]
        if isinstance(value, str):
            rows.append((title, '', value))
        else:
            times = call / value if name == 'mujoco' else value / call
            rows.append((title, f'{1e6 * value:.1f} us', ratio.format(times)))
    ratio = figures['criterion'] / figures['criterion poses']
    rows.append(
        (
            'criterion of a fit, 26 poses, 9 bands',
            f'{1e6 * figures["criterion"]:.0f} us',
            f'{ratio:.2f} times solve_batch of its poses',
        )
    )
    rows.append(('the thesis, 1 GHz laptop', '0.8 ms', 'mean; worst 1.1 ms (ch. 6)'))
    rows += [
        (f'solve_batch, {name}', f'{value:,.0f} frames/s', '')
        for name, value in (figures['frames'] | figures['bands']).items()
    ]
    rows += [
        (f'memory of {int(m):,} frames beyond inputs and outputs', f'{value:.1f} MiB', '')
        for m, value in figures['batch memory'].items()
    ]
    rows += [
        ('process start to first answer, cached', f'{figures["start cached"]:.2f} s', ''),
        ('... not cached: compiling', f'{figures["start cold"]:.1f} s', ''),
        ('... uncompiled', f'{figures["start uncompiled"]:.2f} s', ''),
    ]
    rows += [
        (
            f'linkedplane process, {case}',
            f'{each["processing"]:,.0f} frames/s',
            f'{each["result"] / each["processing"]:.2f} times as long as copying the result, '
            f'{each["source"] / each["processing"]:.2f} as copying the recording',
        )
        for case, each in figures['recordings'].items()
    ]
    rows += latency_rows(figures['latency']) + viewer_rows(figures['viewer'])
    return markdown_table((figures['machine'], '', ''), rows, 'lrl')


def latency_rows(found: dict[str, dict[str, dict[str, float]]]) -> list[tuple[str, str, str]]:
    """Return the table's rows of the node's latency beside the pass-through's."""
    table = []
    for rate, nodes in found.items():
        base = nodes['pass-through']
        for name, each in nodes.items():
            times = ', '.join(f'{1e3 * each[key]:.2f}' for key in ('median', 'p99', 'worst'))
            remark = f'CPU {100 * each["cpu"]:.0f} %, {each["lost"]:.0f} lost'
            if name != 'pass-through':
                ratios = (each[key] / base[key] for key in ('median', 'p99'))
                remark += '; {:.2f} and {:.2f} times the pass-through'.format(*ratios)
            table.append(
                (f'topic to topic, {rate}, {name}: median, p99, worst', f'{times} ms', remark)
            )
    return table


def viewer_rows(found: list[dict[str, Any]] | str) -> list[tuple[str, str, str]]:
    """Return the table's rows of the viewer's latency in a browser."""
    title = 'viewer, slider to drawn path'
    if isinstance(found, str):
        return [(title, '', found)]
    return [
        (
            f'{title}, {each["pixels"]}, '
            f'{"smoothed" if each["samples"] else "plain"} edges: median, 95 %, worst',
            f'{", ".join(f"{1e3 * each[key]:.0f}" for key in ("median", "p95", "worst"))} ms',
            f'headless Chromium, drawn by {each["drawn by"]}',
        )
        for each in found
    ]


def main() -> None:
    """Measure, print the table and write the JSON file."""
    figures = measure()
    print(format_table(figures))
    folder = HERE.parent / 'build'
    folder.mkdir(exist_ok=True)
    (folder / 'bench.json').write_text(json.dumps(figures, indent=2) + '\n')
    print(f'\nwritten to {folder / "bench.json"}; peak memory '
          f'{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MiB')  # fmt: skip


if __name__ == '__main__':
    main()
