# SPDX-License-Identifier: Apache-2.0
"""Linked-plane obstacle-set muscle paths: the deltoid from glenohumeral joint angles.

The names below are the public interface; everything is in SI units, and nothing here needs ROS.
They are imported when first used: an executable can so take care of signals before the compiler of
the solver is loaded.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .errors import LinkedPlaneError, ModelError, RecordingError, SkeletonError
    from .joints.conventions import JOINT_CONVENTIONS, JointConvention
    from .muscle.broad_muscle import BroadMuscle, Head, Landmark
    from .skeleton.girdle import Rest
    from .skeleton.rhythm import Rhythm
    from .skeleton.rhythms import RHYTHMS
    from .skeleton.skeleton import Skeleton
    from .solver.linked_plane_solver import LinkedPlaneSolver
    from .solver.states import MuscleState, MuscleStates, WrapState

__version__ = '0.1.0'
__all__ = [
    'JOINT_CONVENTIONS',
    'RHYTHMS',
    'BroadMuscle',
    'Head',
    'JointConvention',
    'Landmark',
    'LinkedPlaneError',
    'LinkedPlaneSolver',
    'ModelError',
    'MuscleState',
    'MuscleStates',
    'RecordingError',
    'Rest',
    'Rhythm',
    'Skeleton',
    'SkeletonError',
    'WrapState',
]

_PLACES = {
    'errors': ('LinkedPlaneError', 'ModelError', 'RecordingError', 'SkeletonError'),
    'joints.conventions': ('JOINT_CONVENTIONS', 'JointConvention'),
    'muscle.broad_muscle': ('BroadMuscle', 'Head', 'Landmark'),
    'skeleton.girdle': ('Rest',),
    'skeleton.rhythm': ('Rhythm',),
    'skeleton.rhythms': ('RHYTHMS',),
    'skeleton.skeleton': ('Skeleton',),
    'solver.linked_plane_solver': ('LinkedPlaneSolver',),
    'solver.states': ('MuscleState', 'MuscleStates', 'WrapState'),
}
_PLACE = {name: place for place, names in _PLACES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Import a public name from the module that has it."""
    if name not in _PLACE:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    found = getattr(import_module(f'.{_PLACE[name]}', __name__), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """List the public names, imported or not."""
    return sorted([*globals(), *__all__])
