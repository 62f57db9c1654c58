# SPDX-License-Identifier: Apache-2.0
"""Bags of frames in /tf, and where frames stand: (R, t) by SciPy and NumPy alone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from bags import STORE, T0, Sent, write_bag
from reference import Array
from scipy.spatial.transform import Rotation

Standing = tuple[Array, Array]  # R (3, 3), t (3,) m: a point x of the frame stands at R x + t
Hung = tuple[str, str, Standing]  # parent, child, where the child stands
STEP = 10**7  # ns
TF = 'tf2_msgs/msg/TFMessage'


def tf_message(k: int, hung: Iterable[Hung], topic: str = '/tf') -> Sent:
    """Return the k-th frames of a motion at 100 Hz as a message of /tf."""
    types = STORE.types
    stamp = types['builtin_interfaces/msg/Time'](*divmod(T0 + k * STEP, 10**9))
    transforms = []
    for parent, child, (R, t) in hung:
        x, y, z, w = Rotation.from_matrix(R).as_quat().tolist()
        transforms.append(
            types['geometry_msgs/msg/TransformStamped'](
                types['std_msgs/msg/Header'](stamp=stamp, frame_id=parent),
                child,
                types['geometry_msgs/msg/Transform'](
                    types['geometry_msgs/msg/Vector3'](*map(float, t)),
                    types['geometry_msgs/msg/Quaternion'](x, y, z, w),
                ),
            )
        )
    message = types[TF](transforms)
    return topic, TF, T0 + k * STEP, bytes(STORE.serialize_cdr(message, TF))


def pose_bag(path: Path, moments: Sequence[Mapping[str, Standing]], parent: str = 'lab') -> Path:
    """Write a bag of frames that all hang on one parent."""
    return write_bag(
        path,
        [
            tf_message(k, [(parent, child, at) for child, at in moment.items()])
            for k, moment in enumerate(moments)
        ],
    )


def beyond(outer: Standing, inner: Standing) -> Standing:
    """Return where a frame stands that stands at `inner` in one that stands at `outer`."""
    (R, t), (S, s) = outer, inner
    return R @ S, R @ s + t


def seen_from(outer: Standing, frame: Standing) -> Standing:
    """Return where a frame stands in another one, both seen from a third."""
    (R, t), (S, s) = outer, frame
    return R.T @ S, R.T @ (s - t)


def against(moment: Mapping[str, Standing], ground: str) -> dict[str, Standing]:
    """Return where the other frames stand in one of them."""
    return {name: seen_from(moment[ground], at) for name, at in moment.items() if name != ground}


def since(first: Standing, now: Standing) -> Standing:
    """Return the pose of a bone that was at rest where its frame stood at first."""
    R, t = first
    return beyond(now, (R.T, -R.T @ t))


def wandering(k: int) -> Standing:
    """Return where a laboratory's frame may stand at moment k."""
    return Rotation.from_rotvec((0.3, 0.02 * k, -0.5)).as_matrix(), np.array((1.0, 0.01 * k, -2.0))
