# SPDX-License-Identifier: Apache-2.0
"""Moment arms beyond the bound, decided by differences of lengths, for every bundled model.

    python bench/moments.py [ROTATIONS] [SEED]

Of a million random rotations for each model, those at which a moment vector is longer than the
bound (solver/moment_bounds.py) are solved again a little to either side about that vector: the
difference quotient of the lengths, at one step or another, bears the moment vector out or does not.
`make soak` runs it. It ends with status 1 if any is not borne out.
"""

from __future__ import annotations

import sys
from importlib import resources

import numpy as np
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.solver.moment_bounds import moment_arm_bounds
from linkedplane_ros.types import Bools, Floats

PART = 50_000  # rotations at a time
STEPS = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)  # rad: the larger v is, the smaller
WITHIN = 0.02  # relative: rounding of the smallest steps, bends of the largest


def bear_out(
    solver: LinkedPlaneSolver, rotations: Floats, lengths: Floats, band: Floats, vectors: Floats
) -> Bools:
    """Return which moment vectors (k, 3) of a band each are slopes of its lengths, on a side."""
    k = np.arange(len(band))
    sizes = np.linalg.norm(vectors, axis=1)
    axes = vectors / sizes[:, np.newaxis]
    borne = np.zeros(len(band), dtype=bool)
    for step in STEPS:
        ends = [
            solver.solve_batch(Rotation.from_rotvec(h * axes).as_matrix() @ rotations).lengths
            for h in (step, -step)
        ]
        ahead, behind = (end[k, band] for end in ends)
        here = lengths[k, band]
        for slope in (
            (behind - ahead) / (2.0 * step),
            (here - ahead) / step,
            (behind - here) / step,
        ):
            borne |= np.abs(slope - sizes) < WITHIN * sizes
    return borne


def examine(name: str, count: int, seed: int) -> int:
    """Print what is found of a model; return how many moment vectors are not borne out."""
    muscle = BroadMuscle.load(name)
    solver = LinkedPlaneSolver(muscle)
    bounds = moment_arm_bounds(muscle)
    rng = np.random.default_rng(seed)
    beyond = decided = refuted = marked = 0
    most = 0.0
    for start in range(0, count, PART):
        rotations = Rotation.random(min(PART, count - start), rng).as_matrix()
        states = solver.solve_batch(rotations)
        ratio = np.linalg.norm(states.moment_vectors, axis=2) / bounds
        if not np.isfinite(states.moment_vectors).all():
            print(f'{name}: a moment vector is not finite')
            return 1
        marked += int(states.one_sided.any(axis=1).sum())
        long = np.flatnonzero((ratio > 1.0).any(axis=1))
        band = ratio[long].argmax(axis=1)  # the one furthest beyond
        vectors = states.moment_vectors[long, band]
        most = max(most, float(np.linalg.norm(vectors, axis=1).max(initial=0.0)))
        borne = bear_out(solver, rotations[long], states.lengths[long], band, vectors)
        beyond += len(long)
        decided += int(borne.sum())
        refuted += int((~borne).sum())
        for each in long[~borne][:3]:
            print(f'  not borne out: {rotations[each].tolist()}, {ratio[each].max():.3g} bounds')
    print(f'{name}: {count:,} rotations; a moment arm beyond the bound at {beyond:,} '
          f'({100.0 * beyond / count:.2f} %), at most {most:.3g} m; {decided:,} borne out by '
          f'differences of lengths, {refuted:,} not; {marked:,} one-sided')  # fmt: skip
    return refuted


def main() -> int:
    """Examine every bundled model; return the exit status."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 18
    folder = resources.files('linkedplane_ros') / 'models'
    names = sorted(file.name[:-5] for file in folder.iterdir() if file.name.endswith('.yaml'))
    return 1 if sum([examine(name, count, seed) for name in names]) else 0


if __name__ == '__main__':
    sys.exit(main())
