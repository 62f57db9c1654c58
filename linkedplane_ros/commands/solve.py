"""`linkedplane solve`: the muscle at one pose."""

from __future__ import annotations

import argparse
import json
import math

import numpy as np

from ..joints.conventions import JOINT_CONVENTIONS
from ..muscle.broad_muscle import BroadMuscle
from ..solver.linked_plane_solver import LinkedPlaneSolver
from ..solver.states import WrapState
from .values import add_muscle, add_scale, add_side


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the command takes."""
    # fmt: off
    add = parser.add_argument
    add('--convention', choices=tuple(JOINT_CONVENTIONS), required=True,
        help='the joint convention: what the angles mean')
    add('angles', nargs=3, type=float, metavar='ANGLE',
        help="the convention's three angles, in its order, rad")
    add('--degrees', action='store_true', help='the angles are in degrees')
    add('--json', action='store_true', help='print JSON, in m and rad')
    add_side(parser)
    add_muscle(parser)
    add_scale(parser)
    # fmt: on


def run(args: argparse.Namespace) -> None:
    """Print the muscle at one pose."""
    convention = JOINT_CONVENTIONS[args.convention]
    angles = np.array(args.angles) * (math.pi / 180.0 if args.degrees else 1.0)
    if not args.degrees and np.abs(angles).max() > 2.0 * math.pi:
        raise ValueError(f'{np.abs(angles).max():g} rad is more than a full turn; --degrees?')
    solver = LinkedPlaneSolver(BroadMuscle.load(args.muscle).scaled(args.scale), args.side)
    state = solver.solve(convention.rotation(angles))
    arms = state.moment_vectors @ convention.axes(angles, args.side)
    names = solver.muscle.band_names
    if args.json:
        answer = {
            'muscle': solver.muscle.name,
            'side': args.side,
            'convention': convention.name,
            'coordinates': convention.coordinates,
            'angles_rad': angles.tolist(),
            'theta_rad': state.theta,
            'bands': names,
            'lengths_m': state.lengths.tolist(),
            'moment_arms_m': arms.tolist(),
            'moment_vectors_m': state.moment_vectors.tolist(),
            'wrap': [WrapState(w).name for w in state.wrap],
        }
        print(json.dumps(answer, indent=2))
        return
    pose = ', '.join(
        f'{name} {math.degrees(angle):.2f} deg'
        for name, angle in zip(convention.coordinates, angles, strict=True)
    )
    print(f'{solver.muscle.name}, {args.side} shoulder, humerus against scapula: {pose}')
    print(f'{convention.name}: {convention.formula}')
    print('moment arms: positive where shortening turns the joint in the positive direction')
    print()
    columns = ''.join(f'{name[:20]:>21}' for name in convention.coordinates)
    print(f'{"band":<14}{"length":>10}{columns}  wrap')
    print(f'{"":<14}{"mm":>10}' + f'{"mm":>21}' * 3)
    for name, length, arm, wrap in zip(names, state.lengths, arms, state.wrap, strict=True):
        row = ''.join(f'{1e3 * value:21.3f}' for value in arm)
        print(f'{name:<14}{1e3 * length:10.3f}{row}  {WrapState(wrap).name.lower()}')
    print(f'\ntotal {1e3 * state.total_length:.3f} mm, theta {state.theta:.6f} rad')
