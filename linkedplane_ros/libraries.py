# SPDX-License-Identifier: Apache-2.0
"""Libraries that not everybody has, and how to get them."""

from __future__ import annotations

import shlex

REQUIREMENTS = {  # library: what pip installs, where that is not its name
    'dask': 'dask[distributed]',
    'diagnostic_msgs': 'ros-jazzy-common-interfaces',
    'pymoo': 'pymoo>=0.6.2',
    'rclpy': 'ros-jazzy-rclpy',
    'rmw_fastrtps_cpp': 'ros-jazzy-rmw-fastrtps-cpp',
    'sensor_msgs': 'ros-jazzy-common-interfaces',
    'std_msgs': 'ros-jazzy-common-interfaces',
    'visualization_msgs': 'ros-jazzy-common-interfaces',
    'viser': 'viser>=1.1,<2',
}
ROSDEP_KEYS = {  # library: its key in rosdistro, where there is one
    'diagnostic_msgs': 'diagnostic_msgs',
    'matplotlib': 'python3-matplotlib',
    'rclpy': 'rclpy',
    'rmw_fastrtps_cpp': 'rmw_fastrtps_cpp',
    'rosbags': 'python3-rosbags-pip',
    'scipy': 'python3-scipy',
    'sensor_msgs': 'sensor_msgs',
    'std_msgs': 'std_msgs',
    'visualization_msgs': 'visualization_msgs',
}


def advise_install(*libraries: str) -> str:
    """Return how to install libraries: by pip, and the keys by which rosdep knows them."""
    given = dict.fromkeys(REQUIREMENTS.get(name, name) for name in libraries)
    advice = f'pip install {" ".join(map(shlex.quote, given))}'
    keys = [ROSDEP_KEYS[name] for name in libraries if name in ROSDEP_KEYS]
    if not keys:
        return advice
    return f'{advice} (rosdep {"keys" if keys[1:] else "key"}: {", ".join(keys)})'
