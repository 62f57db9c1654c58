# SPDX-License-Identifier: Apache-2.0
"""What shoulder rhythms are worth on recorded motion of the whole girdle: a table in Markdown.

    python bench/rhythms.py BAG...

A bag has the poses of `clavicle`, `scapula` and `humerus` against `thorax` on /tf, right side, in
the model's axes, the arm hanging in the first frame. The deltoid is solved with what a rhythm says
of the others at each humerus, and with what was measured; the difference is the error. Under
"clavicle held" both are `deltoid`, whose clavicle stays where it is on the scapula; under "clavicle
moves" both are `deltoid_girdle`, and what knows no clavicle holds it there too.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from linkedplane_ros import RHYTHMS, BroadMuscle, LinkedPlaneSolver, Rest
from linkedplane_ros.recordings.bags.opening import open_bag
from linkedplane_ros.recordings.frame_tree import rotation_from_quaternion
from linkedplane_ros.recordings.poses import TF_TYPE
from linkedplane_ros.skeleton.followed_girdle import FollowedGirdle
from linkedplane_ros.skeleton.girdle import HUMERUS
from linkedplane_ros.types import Floats

Poses = tuple[Floats, Floats]  # R (m, 3, 3), t (m, 3), m, in the thorax
BONES = 'clavicle', 'scapula', 'humerus'
COLUMNS = (
    '| scapula and clavicle from | scapula, deg | clavicle held: length | moment arm '
    '| clavicle moves: length | moment arm |\n| --- | --- | --- | --- | --- | --- |'
)

CHANGES = (
    '| band | the humerus alone moves | with the scapula | with scapula and clavicle |\n'
    '| --- | --- | --- | --- |'
)


class Answer(NamedTuple):
    """What a muscle answers at each pose."""

    lengths: Floats
    """(m, n) m."""
    arms: Floats
    """(m, n) m, about the axis by which the humerus is raised, the other bones held."""


def read_poses(path: Path) -> dict[str, Poses]:
    """Return the poses of each bone in a bag, frame by frame."""
    turns: dict[str, list[Floats]] = {bone: [] for bone in BONES}
    places: dict[str, list[list[float]]] = {bone: [] for bone in BONES}
    with closing(open_bag(path)) as bag:
        for connection, _, data, *_ in bag.messages():
            if connection.kind != TF_TYPE:
                continue
            for each in bag.read_message(connection, data).transforms:
                if each.child_frame_id in BONES and each.header.frame_id == 'thorax':
                    turn, place = each.transform.rotation, each.transform.translation
                    bone = each.child_frame_id
                    turns[bone].append(rotation_from_quaternion(turn.x, turn.y, turn.z, turn.w))
                    places[bone].append([place.x, place.y, place.z])
    return {bone: (np.array(turns[bone]), np.array(places[bone])) for bone in BONES}


def against_scapula(poses: dict[str, Poses], bone: str) -> Poses:
    """Return a bone's poses in the scapula."""
    (S, s), (R, t) = poses['scapula'], poses[bone]
    back = S.transpose(0, 2, 1)
    return back @ R, np.einsum('mij,mj->mi', back, t - s)


class Comparison:
    """A recorded motion of the girdle, and the muscle at it."""

    def __init__(self, poses: dict[str, Poses]) -> None:
        """Solve the muscle at the true poses."""
        self.poses = poses
        self.first = {bone: (R[:1], t[:1]) for bone, (R, t) in poses.items()}
        self.held = LinkedPlaneSolver(BroadMuscle.load('deltoid'))
        self.moving = LinkedPlaneSolver(BroadMuscle.load('deltoid_girdle'))
        self.angles = np.array([HUMERUS.angles(R) for R in poses['humerus'][0]])
        self.raising = HUMERUS.rotations_and_axes(self.angles)[1][:, :, 1]
        self.truth = self.solve_held(poses), self.solve_moving(poses, self.since_first())

    def since_first(self) -> dict[str, Poses]:
        """Return the clavicle in the scapula since the first frame, as `solve_bones` takes it."""
        R, t = against_scapula(self.poses, 'clavicle')
        turn = R @ R[0].T
        return {'clavicle': (turn, t - turn @ t[0])}

    def solve_held(self, poses: dict[str, Poses]) -> Answer:
        """Return what the muscle without a clavicle answers."""
        states = self.held.solve_batch(against_scapula(poses, 'humerus')[0])
        axes = np.einsum('mji,mj->mi', poses['scapula'][0], self.raising)
        return Answer(states.lengths, np.einsum('mnc,mc->mn', states.moment_vectors, axes))

    def solve_moving(self, poses: dict[str, Poses], clavicle: dict[str, Poses]) -> Answer:
        """Return what the muscle with a clavicle answers; without poses of it, it is held."""
        R, t = against_scapula(poses, 'humerus')
        states = self.moving.solve_bones_batch({'humerus': (R, t), **clavicle})
        axes = np.einsum('mji,mj->mi', poses['scapula'][0], self.raising)
        screws = np.hstack([axes, np.cross(t, axes)])  # about the humerus' centre
        last = states.wrenches[:, :, self.moving.bones.index('humerus') - 1]
        return Answer(states.lengths, np.einsum('mnc,mc->mn', last, screws))

    def compare(self, name: str, poses: dict[str, Poses], clavicle: dict[str, Poses]) -> str:
        """Return the row of what poses the girdle in place of the truth."""
        true, other = self.poses['scapula'][0], poses['scapula'][0]
        cosine = (np.einsum('mij,mij->m', true, other) - 1.0) / 2.0
        off = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
        cells = [f'{off.mean():.1f} / {off.max():.1f}']
        answers = self.solve_held(poses), self.solve_moving(poses, clavicle)
        for answer, truth in zip(answers, self.truth, strict=True):
            for made, meant in zip(answer, truth, strict=True):
                error = 1e3 * np.abs(made - meant)
                cells.append(f'{error.mean():.1f} / {error.max():.1f}')
        return f'| {name} | {" | ".join(cells)} |'

    def compare_rhythm(self, name: str, words: str, rest: Rest | None) -> str:
        """Return the row of a rhythm that starts from a rest."""
        H, rhythm = self.poses['humerus'][0], RHYTHMS[name]
        poses = self.with_scapula([rhythm.pose(R, rest=rest).scapula for R in H])
        followed = FollowedGirdle(HUMERUS, rhythm, rest)
        clavicle = followed.move_bones(self.angles, self.moving.bones, 'right').poses[:, 0]
        moved = {'clavicle': (clavicle[:, :, :3], clavicle[:, :, 3])}
        return self.compare(f'`{name}`, {words}', poses, moved)

    def rows(self) -> Iterator[str]:
        """Yield the rows of the table."""
        yield self.compare('true poses', self.poses, self.since_first())
        yield self.compare('true poses of the scapula, clavicle held', self.poses, {})
        S, C, H = (self.first[bone][0][0] for bone in ('scapula', 'clavicle', 'humerus'))
        rests = {
            'own rest': Rest.measured(S, C, H),
            'average scapula': Rest.measured(None, None, H),
            'no rest': None,
        }
        for name in RHYTHMS:
            for words, rest in rests.items():
                yield self.compare_rhythm(name, words, rest)
        yield self.compare('the first frame, unmoved', self.with_scapula(S), {})
        yield self.compare('angles read as glenohumeral', self.with_scapula(np.eye(3)), {})

    def with_scapula(self, S: npt.ArrayLike) -> dict[str, Poses]:
        """Return the motion with another rotation of the scapula, (3, 3) or (m, 3, 3)."""
        H, centre = self.poses['humerus']
        return {'scapula': (np.broadcast_to(S, H.shape), centre), 'humerus': (H, centre)}

    def changes(self) -> Iterator[str]:
        """Yield a row for each band: by how much its length changes in the motion, mm."""
        alone = self.solve_held(self.with_scapula(self.first['scapula'][0][0]))
        spans = [1e3 * np.ptp(each.lengths, axis=0) for each in (alone, *self.truth)]
        for band, values in zip(self.held.muscle.band_names, np.transpose(spans), strict=True):
            yield f'| {band} | {" | ".join(f"{each:.1f}" for each in values)} |'


def main(paths: list[str]) -> None:
    """Print a table for each recording."""
    for path in map(Path, paths):
        poses = read_poses(path)
        elevations = [np.degrees(HUMERUS.angles(R)[1]) for R in poses['humerus'][0]]
        print(f'`{path.name}`, the arm from {min(elevations):.0f} to {max(elevations):.0f} deg:\n')
        comparison = Comparison(poses)
        print(COLUMNS, *comparison.rows(), sep='\n', end='\n\n')
        print('By how much the length of each band changes in it, mm:\n')
        print(CHANGES, *comparison.changes(), sep='\n', end='\n\n')


if __name__ == '__main__':
    main(sys.argv[1:])
