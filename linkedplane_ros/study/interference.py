# SPDX-License-Identifier: Apache-2.0
"""Which band enters which bone sphere, where and by how much (thesis ch. 5 and Table 5.1).

The thesis counts as interference that any portion of a band touches or falls within a sphere. Here
the whole path is looked at, straight parts and arc, by its exact distance from each centre.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..muscle.broad_muscle import BroadMuscle
from ..muscle.file import read_interference_spheres
from ..muscle.parts import METRES
from ..muscle.yaml_mapping import read_yaml
from ..solver.interference import depths
from ..types import Floats, Point
from .experiments import Experiment

PRINTED = 'as printed'
REVERSED_Z = 'z reversed'
REVERSED_ZY = 'z reversed, y with it'
# Which axes of the obstacle spheres' moving frame each reading reverses (erratum 9): swapping the
# factors of a cross product reverses z; and with z also y, if y = z cross x is taken literally
FRAME_READINGS = {
    PRINTED: (1.0, 1.0, 1.0),
    REVERSED_Z: (1.0, 1.0, -1.0),
    REVERSED_ZY: (1.0, -1.0, -1.0),
}


@dataclass(frozen=True)
class SphereEntry:
    """A band that touches or enters a sphere at a pose."""

    motion: str
    angle: float
    """rad"""
    band: str
    sphere: str
    depth: float
    """How far the path passes under the sphere's surface, m."""
    point: Point
    """The path's point nearest to the sphere's centre, scapula frame, m."""
    wrap: int
    """The band's WrapState."""


@dataclass(frozen=True, eq=False)
class Checks:
    """Which bands enter which spheres: at every pose of the motions, n bands and k spheres."""

    experiments: Sequence[Experiment]
    spheres: tuple[str, ...]
    """(k)"""
    depths: Sequence[Floats]
    """For each motion (m, n, k), m: a sphere's radius minus the path's distance from its centre."""
    points: Sequence[Floats]
    """For each motion (m, n, k, 3), m: the path's nearest points."""

    @property
    def count(self) -> int:
        """How many checks there were."""
        return sum(each.size for each in self.depths)

    @property
    def poses(self) -> int:
        """How many poses there were; the arm at the side counts in every motion."""
        return sum(len(each) for each in self.depths)

    @property
    def entries(self) -> list[SphereEntry]:
        """All entries, by motion, angle, band and sphere."""
        return list(self._entries())

    @property
    def poses_entered(self) -> int:
        """At how many poses there is an entry."""
        return sum(int((each >= 0.0).any(axis=(1, 2)).sum()) for each in self.depths)

    @property
    def entries_of_bands(self) -> npt.NDArray[np.int64]:
        """(n,) How many entries each band has."""
        return np.asarray(sum((each >= 0.0).sum(axis=(0, 2)) for each in self.depths))

    @property
    def deepest_of_bands(self) -> Floats:
        """(n,) The deepest entry of each band, m; negative: the least clearance."""
        return np.asarray(np.max([each.max(axis=(0, 2)) for each in self.depths], axis=0))

    def _entries(self) -> Iterator[SphereEntry]:
        for one, deep, points in zip(self.experiments, self.depths, self.points, strict=True):
            names = one.states.solver.muscle.band_names
            for pose, band, sphere in np.argwhere(deep >= 0.0).tolist():
                x, y, z = points[pose, band, sphere].tolist()
                yield SphereEntry(
                    one.motion.name,
                    float(one.angles[pose]),
                    names[band],
                    self.spheres[sphere],
                    float(deep[pose, band, sphere]),
                    (x, y, z),
                    int(one.states.wrap[pose, band]),
                )


def check_experiments(experiments: Sequence[Experiment]) -> Checks:
    """Check the bands at all poses of experiments against the muscle's interference spheres."""
    entered, nearest = [], []
    muscle = experiments[0].states.solver.muscle
    for one in experiments:
        pairs = [depths(state) for state in one.states]
        entered.append(np.array([depth for depth, _ in pairs]))
        nearest.append(np.array([places for _, places in pairs]))
    return Checks(experiments, muscle.interference_names, entered, nearest)


def apply_reading(muscle: BroadMuscle, reading: str) -> BroadMuscle:
    """Return a muscle with one of the FRAME_READINGS of its obstacle spheres' moving frame.

    Reversing an axis of the frame changes the sign of that coordinate of the centres.
    """
    return replace(muscle, sphere_centres=muscle.sphere_centres * FRAME_READINGS[reading])


def add_spheres(muscle: BroadMuscle, path: str | Path) -> BroadMuscle:
    """Return a muscle with the further interference spheres of a file.

    The file has `units: {length: mm}` and the key `interference_spheres` of a model file.
    ModelError names the file and the key of a fault.
    """
    file = read_yaml(Path(path))
    file.check_keys(('units', 'interference_spheres'))
    units = file.mapping('units')
    units.check_keys(('length',))
    metres = METRES[units.choice('length', METRES)]
    spheres = read_interference_spheres(file)
    if not spheres:
        raise file.fault('interference_spheres', 'at least one sphere expected')
    known = [each.name for each in spheres if each.name in muscle.interference_names]
    if known:
        there = file.mapping('interference_spheres')
        raise there.fault(known[0], 'the model has one of this name')
    centres = metres * np.array([sphere.centre for sphere in spheres])
    radii = metres * np.array([sphere.radius for sphere in spheres])
    return replace(
        muscle,
        interference_names=(*muscle.interference_names, *(sphere.name for sphere in spheres)),
        interference_centres=np.concatenate((muscle.interference_centres, centres)),
        interference_radii=np.concatenate((muscle.interference_radii, radii)),
    )
