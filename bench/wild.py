# SPDX-License-Identifier: Apache-2.0
"""A thousand wild models at a million poses: no length is absurd, no theta is beaten by a scan.

    python bench/wild.py [POSES] [FIRST MODEL] [MODELS]

Every length lies between the straight line's and the tangents' with a whole turn round the sphere,
every number is finite, and no theta of a scan by 0.05 deg makes the muscle shorter by more than
1e-9 m. The scan has its own code: the thesis's appendices B and C, step by step. `make soak` runs
it. It ends with status 1 if a bound is exceeded.
"""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from math import acos, atan2, cos, hypot, pi, sin, sqrt
from pathlib import Path
from typing import Any

import numpy as np

from linkedplane_ros import LinkedPlaneError, LinkedPlaneSolver

sys.path.insert(0, str(Path(__file__).parents[1] / 'test'))

import reference
from random_muscles import LEAST, length_bounds, wild_muscle

try:
    from numba import njit
except ImportError:  # slow, for a few poses

    def njit(**options: Any) -> Any:
        """Return functions as they are."""
        return lambda function: function


STEPS = 7200  # 0.05 deg
ROUNDING = 1e-15  # m


@njit(cache=False, nogil=True)
def band_length(D: float, a: float, R: float, d: float, b: float) -> float:
    """Return a band's length (m) in a plane, as appendix C has it."""
    if abs(d) >= R:
        return D
    r = sqrt(R * R - d * d)
    to_P, to_S = hypot(a, b), hypot(D - a, b)
    if to_P < r or to_S < r:
        return D
    turn = (atan2(-b, -a) - atan2(-b, D - a)) % (2.0 * pi)
    arc = turn - acos(r / to_P) - acos(r / to_S)
    return sqrt(to_P * to_P - r * r) + r * arc + sqrt(to_S * to_S - r * r) if arc > 0.0 else D


@njit(cache=False, nogil=True)
def scan_circle(P: Any, S: Any, C: Any, R: Any, phi: Any, N: Any, known: float) -> float:
    """Return the least total length (m) of STEPS thetas, or `known` if none is shorter.

    A theta is left as soon as the bands from there on cannot make it shorter: in no plane is one
    shorter than its line, nor than the way round its sphere by a great circle, if it must go round.
    """
    n = len(P)
    ux, uy, uz = np.empty(n), np.empty(n), np.empty(n)
    D, a, rest = np.empty(n), np.empty(n), np.zeros(n + 1)
    cosines, sines = np.cos(phi), np.sin(phi)
    for i in range(n - 1, -1, -1):
        x, y, z = S[i, 0] - P[i, 0], S[i, 1] - P[i, 1], S[i, 2] - P[i, 2]
        D[i] = sqrt(x * x + y * y + z * z)
        ux[i], uy[i], uz[i] = x / D[i], y / D[i], z / D[i]
        px, py, pz = C[i, 0] - P[i, 0], C[i, 1] - P[i, 1], C[i, 2] - P[i, 2]
        a[i] = px * ux[i] + py * uy[i] + pz * uz[i]
        rho = sqrt(max(px * px + py * py + pz * pz - a[i] * a[i], 0.0))
        round_it = 0.0 < a[i] < D[i] and rho < R[i]
        rest[i] = rest[i + 1] + (band_length(D[i], a[i], R[i], 0.0, -rho) if round_it else D[i])
    least = known
    for k in range(STEPS):
        theta = -pi + 2.0 * pi * k / STEPS
        cosines[0], sines[0] = cos(theta), sin(theta)
        rx, ry, rz = N[0], N[1], N[2]
        total, kept = 0.0, 1.0
        for i in range(n):
            if total + rest[i] >= least:
                total = 1e300
                break
            x, y, z = ux[i], uy[i], uz[i]
            along = rx * x + ry * y + rz * z
            mx, my, mz = rx - along * x, ry - along * y, rz - along * z
            size = sqrt(mx * mx + my * my + mz * mz)
            kept *= size
            if kept < 1e-6:  # of N, along the chain: no direction to speak of, no candidate
                total = 1e300
                break
            mx, my, mz = mx / size, my / size, mz / size
            c, s = cosines[i], sines[i]
            rx = c * mx + s * (y * mz - z * my)
            ry = c * my + s * (z * mx - x * mz)
            rz = c * mz + s * (x * my - y * mx)
            ex, ey, ez = y * rz - z * ry, z * rx - x * rz, x * ry - y * rx
            px, py, pz = C[i, 0] - P[i, 0], C[i, 1] - P[i, 1], C[i, 2] - P[i, 2]
            d = px * rx + py * ry + pz * rz
            b = px * ex + py * ey + pz * ez
            total += band_length(D[i], a[i], R[i], d, b)
        least = min(least, total)
    return least


def examine(poses: int, seed: int) -> tuple[int, list[str]]:
    """Return how many poses of a model were solved, and what is wrong there."""
    muscle, rotations = wild_muscle(seed, poses)
    try:
        states = LinkedPlaneSolver(muscle).solve_batch(rotations)
    except LinkedPlaneError:
        return 0, []  # a band that has no plane at all is refused, by name
    lines, longest = length_bounds(muscle, rotations)
    ends = np.einsum('mij,nj->mni', rotations, muscle.insertions)
    centres = np.array(np.broadcast_to(reference.sphere_centres(muscle, rotations), ends.shape))
    numbers = muscle.sphere_radii, muscle.plane_angles, muscle.reference_normal
    totals = states.total_length
    scans = [
        scan_circle(muscle.origins, *each, *numbers, total)
        for *each, total in zip(ends, centres, totals, strict=True)
    ]
    checks = {
        'not finite': ~np.isfinite(states.moment_vectors).all(axis=(1, 2)),
        'shorter than its line': (states.lengths < lines - ROUNDING).any(axis=1),
        'longer than can be': (states.lengths > longest + ROUNDING).any(axis=1),
        'beaten by the scan': totals > np.array(scans) + LEAST,
    }
    faults = [
        f'model {seed}, pose {k}: {what} (by {totals[k] - scans[k]:.3g} m in all)'
        for what, wrong in checks.items()
        for k in np.flatnonzero(wrong).tolist()
    ]
    return poses, faults


def main() -> int:
    """Examine the models in two processes, print what is wrong; return the exit status."""
    given = [int(each) for each in sys.argv[1:]]
    poses, first, models = (*given, *(1_000_000, 0, 1000)[len(given) :])
    solved = faulty = 0
    with ProcessPoolExecutor(2) as pool:
        for count, faults in pool.map(
            partial(examine, poses // models), range(first, first + models)
        ):
            solved += count
            faulty += len(faults)
            for fault in faults[:3]:
                print(fault, flush=True)
    print(f'{models:,} wild models, {solved:,} poses solved, {faulty:,} faults')
    return 1 if faulty or not solved else 0


if __name__ == '__main__':
    sys.exit(main())
