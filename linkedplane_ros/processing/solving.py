# SPDX-License-Identifier: Apache-2.0
"""From chunks of a motion to the muscle's states; frames that have none are refused."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from ..errors import LinkedPlaneError
from ..joints.articulation import Articulation
from ..recordings.motion import Chunk, Refusals
from ..skeleton.measured import MeasuredBones, PoseReading
from ..solver.linked_plane_solver import LinkedPlaneSolver
from ..solver.states import AnswerBatch
from ..types import Floats
from .lengthening import LengthRates
from .motion_source import MotionSource
from .outputs import SolvedChunk

POOR_TURN = np.radians(5.0)  # a worse fit of a skeleton is a warning


class Solving(Protocol):
    """Solves the chunks of a motion, one after the other."""

    @property
    def notes(self) -> tuple[str, ...]:
        """What is worth knowing of the answers, a line each."""

    def solve(self, chunk: Chunk) -> SolvedChunk:
        """Return a chunk with the muscle's states, without the frames that are refused."""


def begin_solving(solver: LinkedPlaneSolver, moved: MotionSource, refused: Refusals) -> Solving:
    """Return what solves the chunks of a motion that moves the bones so."""
    if moved.reading is None:
        return ValuesSolving(solver, moved.moved_by, refused)
    assert moved.frames is not None
    return PosesSolving(solver, moved.reading, len(moved.frames.names) - 1, refused)


@dataclass
class ValuesSolving:
    """Solves the muscle at values of coordinates.

    Parameters
    ----------
    solver
        Of the muscle and the side.
    moved_by
        What moves the muscle's bones.
    refused
        Where refused frames are counted.
    """

    solver: LinkedPlaneSolver
    moved_by: Articulation
    refused: Refusals

    @property
    def notes(self) -> tuple[str, ...]:
        """Nothing."""
        return ()

    def solve(self, chunk: Chunk) -> SolvedChunk:
        """Return a chunk's states; frames at which a band has no plane are left out."""
        try:
            unknown = np.isnan(chunk.speeds)
            speeds = np.where(unknown, 0.0, chunk.speeds)
            answers = self.solver.answer_batch(self.moved_by, chunk.angles, speeds)
        except LinkedPlaneError:
            good = np.array([self._has_planes(each) for each in chunk.angles])
            if good.all():
                raise
            for stamp in chunk.stamps[~good].tolist():
                self.refused.add('no_plane', f'stamp {1e-9 * stamp:.2f} s: a band has no plane')
            return self.solve(chunk.select(good))
        lengthening = np.where(unknown.any(axis=1, keepdims=True), np.nan, answers.lengthening)
        return SolvedChunk(chunk, answers.states, answers.moment_arms, lengthening)

    def _has_planes(self, values: Floats) -> bool:
        """Return whether every band has a plane at values (d,) of the coordinates."""
        try:
            self.solver.answer(self.moved_by, values, np.zeros_like(values))
        except LinkedPlaneError:
            return False
        return True


@dataclass
class PosesSolving:
    """Solves the muscle at measured poses of its bones.

    Parameters
    ----------
    solver
        Of the muscle and the side.
    reading
        What finds the coordinates' values in the poses.
    bones
        How many bones are measured against the ground.
    refused
        Where refused frames are counted.
    """

    solver: LinkedPlaneSolver
    reading: PoseReading
    bones: int
    refused: Refusals
    rates: LengthRates = field(default_factory=LengthRates)
    turn: float = 0.0
    """rad, the worst misfit of the values that were found so far."""
    shift: float = 0.0
    """m, the same."""

    @property
    def notes(self) -> tuple[str, ...]:
        """How well the skeleton fits the poses; a warning where it does not."""
        if not self.turn and not self.shift:
            return ()
        poor = 'warning: ' if self.turn > POOR_TURN else ''
        return (
            f'{poor}the skeleton fits the measured poses to {np.degrees(self.turn):.2g} deg and '
            f'{1e3 * self.shift:.2g} mm at worst',
        )

    def solve(self, chunk: Chunk) -> SolvedChunk:
        """Return a chunk's states; frames without an answer are left out."""
        poses = np.empty((0, self.bones, 3, 4)) if chunk.poses is None else chunk.poses
        try:
            measured = self.reading.read_poses(poses)
            answers = self._answer(measured)
        except LinkedPlaneError:
            good = np.array([self._has_answer(k, chunk) for k in range(len(poses))])
            if good.all():
                raise
            return self.solve(chunk.select(good))
        self.turn = max(self.turn, float(measured.turn.max(initial=0.0)))
        self.shift = max(self.shift, float(measured.shift.max(initial=0.0)))
        speeds = np.full(measured.values.shape, np.nan)
        lengthening = self.rates.take(chunk.stamps, answers.states.lengths)
        solved = replace(chunk, angles=measured.values, speeds=speeds)
        return SolvedChunk(solved, answers.states, answers.moment_arms, lengthening)

    def _answer(self, measured: MeasuredBones) -> AnswerBatch:
        values = measured.values
        return self.solver.answer_batch(measured, values, np.zeros_like(values))

    def _has_answer(self, k: int, chunk: Chunk) -> bool:
        """Return whether a frame has an answer; count it if it has none."""
        assert chunk.poses is not None
        where = f'stamp {1e-9 * int(chunk.stamps[k]):.2f} s'
        try:
            measured = self.reading.read_poses(chunk.poses[k : k + 1])
        except LinkedPlaneError as error:
            self.refused.add('no_angles', f'{where}: {error}')
            return False
        try:
            self._answer(measured)
        except LinkedPlaneError:
            self.refused.add('no_plane', f'{where}: a band has no plane')
            return False
        return True
