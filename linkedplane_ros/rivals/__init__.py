# SPDX-License-Identifier: Apache-2.0
"""The rivals of the linked planes as path models of single, independent bands.

The straight line and via points (thesis ch. 3), and the four obstacle sets of Garner and Pandy
(The Obstacle-Set Method for Representing Muscle Paths in Musculoskeletal Models, Comput. Methods
Biomech. Biomed. Eng. 3, 2000, 1-30): single sphere, single cylinder, double cylinder and
sphere-capped cylinder. Each depends only on the pose, and its moment vector is exact.
"""

from .bands import Bands, BandState, BandStates, PathModel, PathState
from .capped_cylinder import CappedCylinder
from .cylinder import Cylinder
from .double_cylinder import DoubleCylinder
from .sphere import Sphere
from .straight import Straight, ViaPoints

__all__ = [
    'BandState',
    'BandStates',
    'Bands',
    'CappedCylinder',
    'Cylinder',
    'DoubleCylinder',
    'PathModel',
    'PathState',
    'Sphere',
    'Straight',
    'ViaPoints',
]
