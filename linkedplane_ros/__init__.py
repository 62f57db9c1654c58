"""Linked-plane obstacle-set muscle paths: the deltoid from glenohumeral joint angles.

The names below are the public interface; everything is in SI units, and nothing here needs ROS.
"""

from .conventions import JOINT_CONVENTIONS, JointConvention
from .model import BroadMuscle, ModelError
from .solver import LinkedPlaneSolver, MuscleState, MuscleStates, WrapState

__all__ = [
    'JOINT_CONVENTIONS',
    'BroadMuscle',
    'JointConvention',
    'LinkedPlaneSolver',
    'ModelError',
    'MuscleState',
    'MuscleStates',
    'WrapState',
]
__version__ = '0.1.0'
