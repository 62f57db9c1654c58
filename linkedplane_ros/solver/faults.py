# SPDX-License-Identifier: Apache-2.0
"""Why a pose has no answer, in words."""

from __future__ import annotations

from ..joints.rotations import FAULTS
from ..muscle.broad_muscle import BroadMuscle
from .kernels import FARTHEST, NO_PLANE, TOO_FAR

NO_PLANE_REASON = (
    'band {} has no plane at this pose: it ends where it begins, or the normal before it runs '
    'along its line'
)
NO_FRAME_REASON = ', or its sphere has no frame: HM lies in line with its origin and SC'


def describe_pose_fault(muscle: BroadMuscle, fault: int, band: int) -> str:
    """Return what a kernel's fault means; `band` is the one that has no plane."""
    if fault == TOO_FAR:
        return f'its shift is beyond {FARTHEST:g} m; m expected'
    if fault != NO_PLANE:
        return FAULTS[fault]
    moving = muscle.sphere_frames[band] == 'moving'
    reason = NO_PLANE_REASON.format(muscle.band_names[band])
    return reason + NO_FRAME_REASON if moving else reason
