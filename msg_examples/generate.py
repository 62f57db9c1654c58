# SPDX-License-Identifier: Apache-2.0
"""Write the sample messages, their expected answers and the arm-raise recording of this folder.

Run it where linkedplane_ros[tools] is installed: `python msg_examples/generate.py [FOLDER]`.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import yaml
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, WrapState
from linkedplane_ros.recordings.bags.topics import JOINT_STATE
from linkedplane_ros.types import Floats

START = 1_700_000_000  # s since the epoch: when the scripted recording begins
SECONDS, RATE = 6.0, 100  # of the arm raise; Hz

# name: (what it is, convention, angles in deg, angular velocities in deg/s, joints around them)
POSES = {
    'arm_at_side': ('the neutral pose', 'flexion_abduction_rotation', (0, 0, 0), (), ()),
    'flexion_80': ('forward flexion', 'flexion_abduction_rotation', (80, 0, 0), (), ()),
    'abduction_90': ('abduction', 'flexion_abduction_rotation', (0, 90, 0), (), ()),
    'moving_abduction': (
        'abduction at 45 deg, going on at 60 deg/s',
        'flexion_abduction_rotation', (0, 45, 0), (0, 60, 0), (),
    ),
    'elevation_isb': (
        'elevation of 60 deg, 30 deg in front of the scapular plane, 20 deg internal rotation',
        'isb_yxy', (30, 60, 20), (), (),
    ),
    'among_other_joints': (
        'abduction of 30 deg in a message of a whole arm',
        'flexion_abduction_rotation', (0, 30, 0), (), ('elbow_flexion', 'wrist_flexion'),
    ),
}  # fmt: skip


def main(folder: Path) -> None:
    """Write everything into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    solver = LinkedPlaneSolver(BroadMuscle.load('deltoid'))
    for name, pose in POSES.items():
        message, expected = build_example(solver, *pose[1:])
        title = f'{pose[0]} ({pose[1]}, right arm, humerus against scapula), rad and rad/s'
        write_yaml(folder / f'{name}.yaml', title, message)
        title = f'the answer to {name}.yaml: SI; positive moment arms shorten with the angle'
        write_yaml(folder / f'{name}.expected.yaml', title, expected)
    write_recording(folder / 'arm_raise')


def build_example(
    solver: LinkedPlaneSolver,
    convention_name: str,
    degrees: tuple[float, ...],
    speeds: tuple[float, ...],
    others: tuple[str, ...],
) -> tuple[dict[str, object], dict[str, object]]:
    """Return a JointState and the expected answer as plain values."""
    convention = JOINT_CONVENTIONS[convention_name]
    angles, rates = np.radians(degrees), np.radians(speeds)
    state = solver.solve(convention.rotation(angles))
    arms = state.moment_vectors @ convention.axes(angles)
    names = [*others, *reversed(convention.coordinates)] if others else [*convention.coordinates]
    by_name = dict(zip(convention.coordinates, angles.tolist(), strict=True))
    message: dict[str, object] = {
        'name': names,
        'position': [by_name.get(name, 0.5) for name in names],
        'velocity': rates.tolist(),
    }
    expected = {
        'joint_convention': convention.name,
        'bands': list(solver.muscle.band_names),
        'coordinates': list(convention.coordinates),
        'band_lengths': round_values(state.lengths),
        'moment_arms': round_values(arms),
        'wrap_states': [WrapState(wrap).name for wrap in state.wrap],
        'lengthening_velocity': round_values(-arms @ rates) if speeds else [],
    }
    return message, expected


def round_values(values: Floats) -> object:
    """Return values as lists of numbers, to 1e-12."""
    return (np.round(values, 12) + 0.0).tolist()


def write_yaml(path: Path, title: str, content: dict[str, object]) -> None:
    """Write content as YAML, a list a line."""
    text = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=10**6)
    path.write_text(f'# SPDX-License-Identifier: Apache-2.0\n# {title}\n{text}', encoding='utf-8')


def arm_raise_frames() -> Iterator[tuple[int, Floats, Floats]]:
    """Yield (ns, angles, velocities) of an arm raised 110 deg in scaption and back.

    A minimum-jerk rise and fall about the scaption axis (sin 30, -cos 30, 0), thesis ch. 5, with
    the humerus turned externally by a third of the elevation.
    """
    convention = JOINT_CONVENTIONS['flexion_abduction_rotation']
    isb = JOINT_CONVENTIONS['isb_yxy']
    plane = np.radians(30.0)
    for k in range(int(SECONDS * RATE) + 1):
        t = k / (SECONDS * RATE)
        x, direction = (2.0 * t, 1.0) if t <= 0.5 else (2.0 - 2.0 * t, -1.0)
        rise = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
        speed = direction * 2.0 / SECONDS * 30.0 * x**2 * (1.0 - x) ** 2
        elevation, rate = np.radians(110.0) * rise, np.radians(110.0) * speed
        # raised about the horizontal axis of the plane: the axial rotation undoes that of the plane
        isb_angles = np.array([plane, elevation, -plane - elevation / 3.0])
        omega = isb.axes(isb_angles) @ np.array([0.0, rate, -rate / 3.0])
        angles = convention.angles(isb.rotation(isb_angles))
        velocities = np.linalg.solve(convention.axes(angles), omega)
        yield START * 10**9 + k * 10**9 // RATE, angles, velocities


def write_recording(folder: Path) -> None:
    """Write the arm raise as a rosbag2 (mcap)."""
    store = get_typestore(Stores.ROS2_JAZZY)
    types = store.types
    names = list(JOINT_CONVENTIONS['flexion_abduction_rotation'].coordinates)
    if folder.exists():
        shutil.rmtree(folder)
    with Writer(folder, version=8, storage_plugin=StoragePlugin.MCAP) as bag:
        connection = bag.add_connection('/joint_states', JOINT_STATE, typestore=store)
        for nanoseconds, angles, velocities in arm_raise_frames():
            seconds, rest = divmod(nanoseconds, 10**9)
            stamp = types['builtin_interfaces/msg/Time'](sec=seconds, nanosec=rest)
            message = types[JOINT_STATE](
                header=types['std_msgs/msg/Header'](stamp=stamp, frame_id=''),
                name=names,
                position=angles,
                velocity=velocities,
                effort=np.empty(0),
            )
            bag.write(connection, nanoseconds, store.serialize_cdr(message, JOINT_STATE))


if __name__ == '__main__':
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
