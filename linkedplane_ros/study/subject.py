# SPDX-License-Identifier: Apache-2.0
"""The subject of a study: a muscle, its experiments, and which literature applies to it."""

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
from .experiments import MOTIONS, Experiment, simulate_motion
from .fidelity import is_comparable
from .interference import add_spheres, apply_reading

FINE = math.radians(1.0)  # from pose to pose of a drawn curve


@dataclass(frozen=True, eq=False)
class Subject:
    """A muscle under study, right shoulder."""

    model: str
    """The bundled model's name, or the model file's path."""
    muscle: BroadMuscle
    """With the further interference spheres, if there are any."""
    scale: float
    """The factor of the moment arms: 1, or the thesis's half."""
    spheres: str | None
    """The file of the further interference spheres."""

    @staticmethod
    def load(model: str, scale: float = 1.0, spheres: str | Path | None = None) -> Subject:
        """Load a model.

        Parameters
        ----------
        model
            A bundled model's name, or the path of a model file.
        scale
            The factor of the moment arms.
        spheres
            A file of further interference spheres.

        Raises
        ------
        ModelError
            If a file cannot be used; the message names it and the reason.
        """
        muscle = BroadMuscle.load(model)
        muscle.require_ball_joint('a study')
        if spheres is not None:
            muscle = add_spheres(muscle, spheres)
        return Subject(model, muscle, scale, None if spheres is None else str(spheres))

    @cached_property
    def solver(self) -> LinkedPlaneSolver:
        """The solver of the muscle."""
        return LinkedPlaneSolver(self.muscle)

    @cached_property
    def experiments(self) -> list[Experiment]:
        """The thesis's three motions, every 10 deg."""
        return [simulate_motion(self.solver, motion, scale=self.scale) for motion in MOTIONS]

    @cached_property
    def curves(self) -> list[Experiment]:
        """The same motions, every degree, for drawn curves."""
        return [
            simulate_motion(self.solver, motion, motion.angles(FINE), self.scale)
            for motion in MOTIONS
        ]

    @cached_property
    def is_published(self) -> bool:
        """Whether it is the thesis's own deltoid."""
        return is_published(self.muscle)

    @cached_property
    def is_comparable(self) -> bool:
        """Whether there are measurements of its heads."""
        return is_comparable(self.muscle)

    def with_frame_reading(self, reading: str) -> Subject:
        """Return the subject with one of interference.FRAME_READINGS."""
        return replace(self, muscle=apply_reading(self.muscle, reading))

    def solve_pose(self, motion: str, degrees: float) -> MuscleState:
        """Return the muscle's state at an angle, deg, of one of the motions."""
        (chosen,) = (each for each in MOTIONS if each.name == motion)
        return simulate_motion(self.solver, chosen, np.radians([degrees])).states[0]
