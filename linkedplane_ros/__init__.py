"""Linked-plane obstacle-set muscle paths: the deltoid from glenohumeral joint angles.

The names below are the public interface; everything is in SI units, and nothing here needs ROS.
They are imported when first used: an executable can so take care of signals before the compiler of
the solver is loaded.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .conventions import JOINT_CONVENTIONS, JointConvention
    from .model import BroadMuscle, Head, Landmark, ModelError
    from .solver import LinkedPlaneSolver, MuscleState, MuscleStates, WrapState

__all__ = [
    'JOINT_CONVENTIONS',
    'BroadMuscle',
    'Head',
    'JointConvention',
    'Landmark',
    'LinkedPlaneSolver',
    'ModelError',
    'MuscleState',
    'MuscleStates',
    'WrapState',
]
__version__ = '0.1.0'

_MODULES = ('conventions', 'model', 'solver')


def __getattr__(name: str) -> Any:
    """Import a public name from the module that has it."""
    if name in __all__:
        for module in _MODULES:
            found = getattr(import_module(f'.{module}', __name__), name, None)
            if found is not None:
                globals()[name] = found
                return found
    raise AttributeError(f'module {__name__!r} has no attribute {name!r}')


def __dir__() -> list[str]:
    """List the public names, imported or not."""
    return sorted([*globals(), *__all__])
