"""`linkedplane info`: look at a model."""

from __future__ import annotations

import argparse

import numpy as np

from ..model import BroadMuscle
from ..solver import LinkedPlaneSolver, WrapState


def arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the command takes."""
    parser.add_argument('muscle', nargs='?', default='deltoid', metavar='MUSCLE',
                     help='a bundled model or a .yaml file (default: deltoid)')  # fmt: skip


def run(args: argparse.Namespace) -> None:
    """Print a muscle model."""
    muscle = BroadMuscle.load(args.muscle)
    state = LinkedPlaneSolver(muscle).solve(np.eye(3))
    print(f'{muscle.name}: {len(muscle.band_names)} bands, {len(muscle.heads)} heads')
    print(muscle.source)
    print('right shoulder; x lateral, y anterior, z superior; lengths in mm, angles in rad')
    print()
    print(f'{"band":<14}{"head":<12}{"origin (scapula)":>24}{"insertion (humerus)":>24}'
          f'{"radius":>8}{"phi":>8}{"length":>8}  wrap')  # fmt: skip
    for i, band in enumerate(muscle.band_names):
        origin, insertion = (
            ' '.join(f'{1e3 * x:7.1f}' for x in point[i])
            for point in (muscle.origins, muscle.insertions)
        )
        phi = 'theta' if i == 0 else f'{muscle.plane_angles[i]:.3f}'
        print(f'{band:<14}{muscle.head_of(band):<12}{origin:>24}{insertion:>24}'
              f'{1e3 * muscle.sphere_radii[i]:8.1f}{phi:>8}{1e3 * state.lengths[i]:8.1f}'
              f'  {WrapState(state.wrap[i]).name.lower()}')  # fmt: skip
    print()
    print(f'arm at the side: theta {state.theta:.6f} rad, total {1e3 * state.total_length:.3f} mm')
    for head in muscle.heads:
        print(f'{head.name}: {", ".join(head.bands)}; represented by {head.represented_by}')
