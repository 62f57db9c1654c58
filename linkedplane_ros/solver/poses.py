# SPDX-License-Identifier: Apache-2.0
"""The poses of bones as a user gives them, by name, and as the kernels take them: (m, k, 3, 4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import LinkedPlaneError, describe_value
from ..joints.articulation import rest_poses
from ..joints.rotations import as_floats
from ..types import Floats

Pose = tuple[Any, Any]
"""(R, t): a point x of the bone stands at R x + t in the ground frame; R (3, 3), t (3,) m."""


def pack_poses(bones: Sequence[str], given: Mapping[str, Pose]) -> Floats:
    """Return one pose of each bone that moves, (1, k, 3, 4); those not given are at rest.

    Values are checked by the kernel. LinkedPlaneError for a bone that is not one of `bones`, the
    ground first, and for anything but numbers of the shapes of R and t.
    """
    arrays = _as_arrays(bones, given, (3, 3), (3,))
    return _fill_poses(bones, {name: (R[np.newaxis], t[np.newaxis]) for name, R, t in arrays}, 1)


def pack_pose_batch(bones: Sequence[str], given: Mapping[str, Pose]) -> Floats:
    """Return m poses of each bone that moves, (m, k, 3, 4); as `pack_poses`."""
    arrays = _as_arrays(bones, given, ('m', 3, 3), ('m', 3))
    if not arrays:
        expected = f'at least one of {", ".join(bones[1:])} expected'
        raise LinkedPlaneError(f'bones: none given, {expected}: it says how many poses there are')
    first, counted, _ = arrays[0]
    m = len(counted)
    for name, R, t in arrays:
        for what, array in ('rotations', R), ('shifts', t):
            if len(array) != m:
                raise LinkedPlaneError(
                    f'{name}: {len(array)} {what} given, {m} expected, as there are rotations of '
                    f'{first}'
                )
    return _fill_poses(bones, {name: (R, t) for name, R, t in arrays}, m)


def _fill_poses(bones: Sequence[str], arrays: dict[str, tuple[Floats, Floats]], m: int) -> Floats:
    poses = rest_poses(m, len(bones) - 1)
    for name, (R, t) in arrays.items():
        k = bones.index(name) - 1
        poses[:, k, :, :3], poses[:, k, :, 3] = R, t
    return poses


def _as_arrays(
    bones: Sequence[str],
    given: Mapping[str, Pose],
    *shapes: tuple[str | int, ...],
) -> list[tuple[str, Floats, Floats]]:
    """Return name, R and t of each bone that is given, with the shapes that are expected."""
    if not isinstance(given, Mapping):
        expected = 'a mapping of bones to their poses (R, t) expected'
        raise LinkedPlaneError(f'bones: {describe_value(given)} given, {expected}')
    arrays = []
    for name, pose in given.items():
        if name == bones[0]:
            raise LinkedPlaneError(
                f'bones: {name} given, which is the ground and does not move; '
                f'{", ".join(bones[1:])} expected'
            )
        if name not in bones:
            expected = f'one of {", ".join(bones[1:])} expected'
            raise LinkedPlaneError(f'bones: {describe_value(name)} given, {expected}')
        if isinstance(pose, (str, bytes)) or not isinstance(pose, Sequence) or len(pose) != 2:
            expected = f'a rotation {_describe(shapes[0])} and a shift {_describe(shapes[1])}'
            raise LinkedPlaneError(f'{name}: {describe_value(pose)} given, {expected} expected')
        R, t = (
            _as_shape(f'{name}: {what}', values, shape)
            for what, values, shape in zip(('rotation', 'shift'), pose, shapes, strict=True)
        )
        arrays.append((name, R, t))
    return arrays


def _as_shape(name: str, values: Any, shape: tuple[str | int, ...]) -> Floats:
    array = as_floats(name, values, _describe(shape))
    if array.shape == (0,) and shape[0] == 'm':
        array = array.reshape(0, *(size for size in shape if isinstance(size, int)))
    suits = array.ndim == len(shape) and all(
        given == size for given, size in zip(array.shape, shape, strict=True) if size != 'm'
    )
    if not suits:
        raise LinkedPlaneError(f'{name}: shape {array.shape} given, {_describe(shape)} expected')
    return array


def _describe(shape: tuple[str | int, ...]) -> str:
    return f'({", ".join(map(str, shape))}{"," if len(shape) == 1 else ""})'
