# SPDX-License-Identifier: Apache-2.0
"""`linkedplane solve`: the muscle at one pose."""

from __future__ import annotations

import argparse
import json
import math
from typing import Any

import numpy as np

from ..errors import LinkedPlaneError
from ..joints.conventions import JOINT_CONVENTIONS, JointConvention
from ..muscle.broad_muscle import BroadMuscle
from ..solver.linked_plane_solver import LinkedPlaneSolver
from ..solver.states import MuscleState, WrapState
from ..types import Floats
from .argument_types import add_muscle, add_scale, add_side


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
        raise LinkedPlaneError(f'{np.abs(angles).max():g} rad is more than a full turn; --degrees?')
    solver = LinkedPlaneSolver(BroadMuscle.load(args.muscle).scaled(args.scale), args.side)
    state = solver.solve(convention.rotation(angles))
    arms = state.moment_vectors @ convention.axes(angles, args.side)
    if args.json:
        print(json.dumps(describe_state(state, convention, angles, arms), indent=2))
    else:
        print_state(state, convention, angles, arms)


def describe_state(
    state: MuscleState, convention: JointConvention, angles: Floats, arms: Floats
) -> dict[str, Any]:
    """Return what --json prints: the state at angles (3,), rad, with moment arms (n, 3), m."""
    return {
        'muscle': state.solver.muscle.name,
        'side': state.solver.side,
        'convention': convention.name,
        'coordinates': convention.coordinates,
        'angles_rad': angles.tolist(),
        'theta_rad': state.theta,
        'bands': state.solver.muscle.band_names,
        'lengths_m': state.lengths.tolist(),
        'moment_arms_m': arms.tolist(),
        'moment_vectors_m': state.moment_vectors.tolist(),
        'wrap': [WrapState(w).name for w in state.wrap],
    }


def print_state(
    state: MuscleState, convention: JointConvention, angles: Floats, arms: Floats
) -> None:
    """Print the state at angles (3,), rad, with moment arms (n, 3), m, as a table in mm and deg."""
    muscle, side = state.solver.muscle, state.solver.side
    pose = ', '.join(
        f'{name} {math.degrees(angle):.2f} deg'
        for name, angle in zip(convention.coordinates, angles, strict=True)
    )
    print(f'{muscle.name}, {side} shoulder, humerus against scapula: {pose}')
    print(f'{convention.name}: {convention.formula}')
    print('moment arms: positive where shortening turns the joint in the positive direction')
    print()
    columns = ''.join(f'{name[:20]:>21}' for name in convention.coordinates)
    print(f'{"band":<14}{"length":>10}{columns}  wrap')
    print(f'{"":<14}{"mm":>10}' + f'{"mm":>21}' * 3)
    rows = zip(muscle.band_names, state.lengths, arms, state.wrap, strict=True)
    for name, length, arm, wrap in rows:
        cells = ''.join(f'{1e3 * value:21.3f}' for value in arm)
        print(f'{name:<14}{1e3 * length:10.3f}{cells}  {WrapState(wrap).name.lower()}')
    print(f'\ntotal {1e3 * state.total_length:.3f} mm, theta {state.theta:.6f} rad')
