"""What a study is of: a muscle, its experiments, and what of the literature applies to it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from ..muscle.broad_muscle import BroadMuscle
from ..solver.linked_plane_solver import LinkedPlaneSolver
from ..solver.states import MuscleState
from .attachments import is_published
from .experiments import MOTIONS, Experiment, simulate
from .fidelity import is_comparable
from .interference import read_as, with_spheres

FINE = math.radians(1.0)  # from pose to pose of a drawn curve


@dataclass(frozen=True, eq=False)
class Subject:
    """A muscle under study, right shoulder."""

    model: str
    """The bundled model's name, or the model file's path."""
    muscle: BroadMuscle
    """With the further interference spheres, if there are any."""
    scale: float
    """Of the moment arms: 1, or the thesis's half."""
    spheres: str | None
    """The file of the further interference spheres."""

    @staticmethod
    def load(model: str, scale: float = 1.0, spheres: str | Path | None = None) -> Subject:
        """Load a model and, if given, a file of further spheres; ModelError says what is wrong."""
        muscle = BroadMuscle.load(model)
        if spheres is not None:
            muscle = with_spheres(muscle, spheres)
        return Subject(model, muscle, scale, None if spheres is None else str(spheres))

    @cached_property
    def solver(self) -> LinkedPlaneSolver:
        """The solver of the muscle."""
        return LinkedPlaneSolver(self.muscle)

    @cached_property
    def experiments(self) -> list[Experiment]:
        """The thesis's three motions, every 10 deg."""
        return [simulate(self.solver, motion, scale=self.scale) for motion in MOTIONS]

    @cached_property
    def curves(self) -> list[Experiment]:
        """The same, every degree."""
        return [
            simulate(self.solver, motion, motion.angles(FINE), self.scale) for motion in MOTIONS
        ]

    @cached_property
    def is_published(self) -> bool:
        """Whether it is the thesis's own deltoid."""
        return is_published(self.muscle)

    @cached_property
    def is_comparable(self) -> bool:
        """Whether measurements of its heads are at hand."""
        return is_comparable(self.muscle)

    def read_as(self, reading: str) -> Subject:
        """Return the same with one of interference.READINGS of the obstacle spheres' frame."""
        return replace(self, muscle=read_as(self.muscle, reading))

    def at(self, motion: str, degrees: float) -> MuscleState:
        """Return the muscle's state at an angle, deg, of one of the motions."""
        (found,) = (each for each in MOTIONS if each.name == motion)
        one = simulate(self.solver, found, np.radians([degrees]))
        return one.states[0]
