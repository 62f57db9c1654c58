# SPDX-License-Identifier: Apache-2.0
"""A skeleton: the poses of a muscle's bones, and their screws, from the values of joints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from importlib import resources
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..errors import SkeletonError, describe_value
from ..files import read_regular_file
from ..joints.articulation import MovedBones
from ..joints.conventions import as_triple
from ..joints.rotations import as_floats
from ..joints.sides import check_side, mirror_poses, mirror_screws
from ..types import Floats, Intervals
from .bone_place import Origin, split_place
from .joint_tree import JointTree, list_names
from .kinematics import FACTOR, SOURCE, Chain, pose_bones
from .packing import pack_tree, place_in_link
from .urdf import EXPAND, MOST_BYTES, parse_urdf

BonePose = tuple[Floats, Floats]
"""(R, t): a point x of the bone stands at R x + t in the ground bone's frame."""
SAME_PLACE: Origin = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Skeleton:
    """A tree of revolute, continuous, prismatic, fixed and mimic joints, and the bones it moves.

    Bones are links, the first of them the ground: poses and screws are seen from it. It need not be
    the root. A skeleton for the bones of a muscle (`for_bones`; the bundled ones are) has them as
    muscle models do: at rest all bone frames coincide with the ground's, and all poses are the
    identity. The skeleton of a URDF that names no bones has every link as a bone, the root as the
    ground, and the links' own frames.
    """

    tree: JointTree = field(repr=False)
    """Links and joints, as the URDF has them."""
    bones: tuple[str, ...]
    """What the muscle calls the bones; the ground first, then those that move, k of them."""
    links: tuple[str, ...]
    """The links that are these bones."""
    rest: tuple[float, ...] | None = None
    """(d,) rad or m, where the bones' frames coincide; None where each has its link's own."""
    origin: Origin = SAME_PLACE
    """Of the ground's frame in its link."""
    places: tuple[Origin | None, ...] = ()
    """Of the other bones' frames in theirs; None, or none of them: where they coincide at rest."""

    @property
    def side(self) -> str:
        """The side of the body that the URDF says it is of; empty: that of its muscle."""
        return self.tree.side

    @staticmethod
    def load(name: str | Path) -> Skeleton:
        """Return a bundled skeleton, or the one in a file.

        Parameters
        ----------
        name
            'shoulder_girdle' or 'hip', or the path of a .urdf file, at most 16 MiB.

        Returns
        -------
        Skeleton
            With the bones that the URDF names, or with all its links.

        Raises
        ------
        SkeletonError
            One line that names the file, the joint or link and the reason.

        """
        text, bundled = str(name), bundled_skeletons()
        if text in bundled:
            return Skeleton.from_urdf(bundled[text], text)
        path = Path(text)
        if path.suffix != '.urdf':
            hint = f'; {EXPAND}' if path.suffix == '.xacro' else ''
            raise SkeletonError(
                f'skeleton: {describe_value(text)} is neither a bundled skeleton '
                f'({", ".join(sorted(bundled))}) nor a path to a .urdf file{hint}'
            )
        return Skeleton.from_urdf(read_regular_file(path, MOST_BYTES, SkeletonError), text)

    @staticmethod
    def from_urdf(text: str | bytes, name: str = 'robot_description') -> Skeleton:
        """Return the skeleton in a URDF's text.

        Parameters
        ----------
        text
            The URDF; xacro expanded.
        name
            What messages call it.

        Returns
        -------
        Skeleton
            With the bones that it names, or with all its links.

        Raises
        ------
        SkeletonError
            One line that names the joint or link and the reason.

        """
        tree = parse_urdf(name, text)
        if tree.bones:
            return Skeleton(tree, tree.links, tree.links).for_bones(tree.bones)
        links = (tree.root, *(joint.child for joint in tree.order_joints()))
        return Skeleton(tree, links, links)

    def for_bones(
        self,
        bones: Sequence[str],
        bone_links: Mapping[str, str] | Iterable[str] | None = None,
        rest: Mapping[str, float] | None = None,
        origin: Origin | None = None,
    ) -> Skeleton:
        """Return the skeleton for a muscle's bones.

        The frame of the muscle's ground bone is that of its link, or stands there at `origin`. The
        frames of the other bones follow: they coincide with it at rest, whatever frames their links
        have.

        Of a skeleton that was made so already, what is not given anew is kept: the values at rest,
        and of each bone its link and what was said of its place there.

        Parameters
        ----------
        bones
            The muscle's (`solver.bones`): the ground first, then those that move.
        bone_links
            The link of a bone that is not named as the bone, as one with a robot's prefix; or
            entries BONE:=LINK. Bones that do not move against each other may share a link.
            `LINK@X,Y,Z,ROLL,PITCH,YAW` says where the bone's frame stands in it as well, in m and
            rad: for the ground what `origin` says, for another bone in place of what follows from
            `rest`.
        rest
            The coordinates at the muscle's rest, rad or m; those not named are 0, or as they were.
        origin
            Where the muscle's ground frame stands in the ground's link: (x, y, z) in m, and roll,
            pitch and yaw in rad. None: as it was, or at the link's own frame.

        Returns
        -------
        Skeleton
            With the same coordinates; those that move no bone against the ground have screws of 0.

        Raises
        ------
        SkeletonError
            For a bone without a link, and names that are no bone or coordinate of it.

        """
        names = self._as_bones(bones)
        renamed = self._as_links(bone_links, names)
        known = {
            bone: (link, place)
            for bone, link, place in zip(self.bones, self.links, self._said_places, strict=True)
        }
        links, places = [], []
        for bone in names:
            link, place = split_place(bone, renamed.get(bone, bone), self.tree.links)
            known_link, known_place = known.get(bone, (link, None))
            if bone not in renamed:
                link = known_link
            if link == known_link:
                place = place or known_place
            links.append(self._find_link(bone, link))
            places.append(place)
        said = split_place(names[0], renamed.get(names[0], names[0]), self.tree.links)[1]
        ground = said or (None if origin is None else _as_origin(origin)) or places[0] or SAME_PLACE
        return Skeleton(
            self.tree, names, tuple(links), self._merge_rest(rest), ground, tuple(places[1:])
        )

    @property
    def _said_places(self) -> tuple[Origin | None, ...]:
        """Of each bone its frame's place in its link, where somebody said it."""
        ground = None if self.origin == SAME_PLACE else self.origin
        return ground, *(self.places or (None,) * (len(self.bones) - 1))

    def _as_bones(self, bones: Sequence[str]) -> tuple[str, ...]:
        given = f'bones: {describe_value(bones)} given, a list of names expected'
        if isinstance(bones, str) or not isinstance(bones, Iterable):
            raise self.tree.fault(given)
        names = tuple(bones)
        if not names or not all(isinstance(each, str) for each in names):
            raise self.tree.fault(given)
        if len(set(names)) < len(names):
            raise self.tree.fault(f'bones: {list_names(names)} given, names that differ expected')
        return names

    def _as_links(
        self, bone_links: Mapping[str, str] | Iterable[str] | None, bones: Sequence[str]
    ) -> Mapping[str, str]:
        links = bone_links or {}
        if not isinstance(links, Mapping):
            if isinstance(links, str) or not isinstance(links, Iterable):
                given = describe_value(links)
                raise self.tree.fault(
                    f'bone_links: {given} given, a mapping of bones to links, or a list of '
                    'BONE:=LINK expected'
                )
            links = parse_bone_links(links)
        for bone, link in links.items():
            if bone not in bones:
                raise self.tree.fault(
                    f'bone_links: {describe_value(bone)} is no bone; those are {list_names(bones)}'
                )
            if not isinstance(link, str):
                given = describe_value(link)
                raise self.tree.fault(
                    f'bone_links: {bone}: {given} given, the name of a link expected'
                )
        return links

    def _merge_rest(self, rest: Mapping[str, float] | None) -> tuple[float, ...]:
        """Return the values (d,) at rest: those given, and of the others those there were, or 0."""
        if not isinstance(rest or {}, Mapping):
            raise self.tree.fault(
                f'rest: {describe_value(rest)} given, a mapping of coordinates to values expected'
            )
        known = self.rest or (0.0,) * len(self.coordinates)
        at_rest = dict(zip(self.coordinates, known, strict=True))
        for name, value in (rest or {}).items():
            if name not in at_rest:
                raise self.tree.fault(
                    f'rest: {describe_value(name)} is no coordinate; '
                    f'those are {list_names(self.coordinates)}'
                )
            at_rest[name] = value
        return tuple(self._as_values(list(at_rest.values()), 'rest').tolist())

    def _find_link(self, bone: str, link: str) -> str:
        if link in self.tree.links:
            return link
        named = 'of that name' if link == bone else describe_value(link)
        alike = [each for each in self.tree.links if link in each]
        raise self.tree.fault(
            f'no link {named} for bone {describe_value(bone)}; its links are '
            f'{list_names(alike or self.tree.links)}; bone_links: {bone}:=LINK names another'
        )

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the independent joints, d of them, as the URDF lists them."""
        return tuple(joint.name for joint in self.tree.independent)

    @property
    def kinds(self) -> tuple[str, ...]:
        """Of each coordinate: 'revolute', 'continuous' (both rad) or 'prismatic' (m)."""
        return tuple(joint.kind for joint in self.tree.independent)

    @property
    def limits(self) -> Intervals:
        """Of each coordinate, rad or m: infinite where it has none. Poses beyond are answered."""
        return tuple(joint.limits for joint in self.tree.independent)

    @property
    def frames(self) -> Floats:
        """(1 + k, 3, 4) the bones' frames in their links: of rest, they coincide there."""
        return self._chain.frames

    @property
    def moving(self) -> tuple[str, ...]:
        """The coordinates that move a bone against the ground: those that its muscle needs."""
        chain = self._chain
        moves = (chain.ways != 0).any(axis=0) & (chain.numbers[:, FACTOR] != 0.0)
        used = set(chain.joints[moves, SOURCE].tolist())
        return tuple(name for i, name in enumerate(self.coordinates) if i in used)

    def pose(self, q: npt.ArrayLike, side: str = '') -> dict[str, BonePose]:
        """Return the poses of the moving bones.

        Parameters
        ----------
        q
            (d,) rad, or m of prismatic joints, in the order of `coordinates`.
        side
            The muscle's (`solver.side`): poses are then as `solve_bones` takes them, in
            right-shoulder form, of a skeleton as `move_bones` says. Empty: as the URDF has them,
            which for a muscle is right only if it and the skeleton are of the right side.

        Returns
        -------
        dict
            Of each moving bone (R, t), (3, 3) and (3,) m, in the ground bone's frame: a point x of
            the bone stands at R x + t.

        Raises
        ------
        LinkedPlaneError
            For anything but d finite numbers, and for another side.

        """
        return self.pose_and_screws(q, side)[0]

    def screws(self, q: npt.ArrayLike, side: str = '') -> Floats:
        """Return how each coordinate moves each bone.

        Parameters
        ----------
        q
            (d,) as for `pose`.
        side
            The muscle's (`solver.side`): screws are then in the frame of that side, as the
            `wrenches` of a state are. Empty: as the URDF has them, as for `pose`.

        Returns
        -------
        Floats
            (d, k, 6) the screw (w, v) at unit speed: w turns the bone about the ground's axes, v is
            the velocity of its point at the ground's origin, m (of prismatic joints: 0 and 1). The
            joints that follow a coordinate (mimic) are in it.

        Raises
        ------
        LinkedPlaneError
            As `pose`.

        """
        return self.pose_and_screws(q, side)[1]

    def pose_and_screws(
        self, q: npt.ArrayLike, side: str = ''
    ) -> tuple[dict[str, BonePose], Floats]:
        """Return `pose` and `screws` at once.

        Parameters
        ----------
        q
            (d,) as for `pose`.
        side
            As for `pose` and `screws`.

        Returns
        -------
        pose : dict
            Of each moving bone (R, t), as `pose` has it.
        screws : Floats
            (d, k, 6) as `screws` has them.

        Raises
        ------
        LinkedPlaneError
            As `pose`.

        """
        poses, screws = self._move_for(self._as_values(q)[np.newaxis], side)
        return {
            bone: (pose[:, :3], pose[:, 3])
            for bone, pose in zip(self.bones[1:], poses[0], strict=True)
        }, screws[0]

    def pose_ground(self, q: npt.ArrayLike, side: str = '') -> Floats:
        """Return where the ground bone's frame stands in the frame of the root.

        Parameters
        ----------
        q
            (d,) as for `pose`; of the joints between root and ground, too, which move no bone
            against the ground.
        side
            The muscle's: in a skeleton of the other side its ground is the mirror image. Empty:
            that of the skeleton.

        Returns
        -------
        Floats
            (3, 4) R and t, m, side by side: a point x of the ground's frame stands at R x + t in
            the root's.

        Raises
        ------
        LinkedPlaneError
            As `pose`.

        """
        if side != '':
            check_side(side)
        pose = self._from_root._move(self._as_values(q)[np.newaxis]).poses[0, 0]
        return mirror_poses(pose) if side and self.side and side != self.side else pose

    def pose_batch(self, q: npt.ArrayLike, side: str = '') -> dict[str, BonePose]:
        """Return the poses at many values; each is, to the bit, that of `pose`.

        Parameters
        ----------
        q
            (m, d) as for `pose`; m may be 0.
        side
            As for `pose`.

        Returns
        -------
        dict
            Of each moving bone (m, 3, 3) and (m, 3) m.

        Raises
        ------
        LinkedPlaneError
            As `pose`.

        """
        poses = self._move_for(self._as_values(q, batch=True), side).poses
        return {
            bone: (poses[:, k, :, :3], poses[:, k, :, 3]) for k, bone in enumerate(self.bones[1:])
        }

    def screws_batch(self, q: npt.ArrayLike, side: str = '') -> Floats:
        """Return the screws at many values; each is, to the bit, that of `screws`.

        Parameters
        ----------
        q
            (m, d) as for `pose`; m may be 0.
        side
            As for `screws`.

        Returns
        -------
        Floats
            (m, d, k, 6) as `screws` has them.

        Raises
        ------
        LinkedPlaneError
            As `pose`.

        """
        return self._move_for(self._as_values(q, batch=True), side).screws

    def move_bones(self, values: npt.ArrayLike, bones: Sequence[str], side: str) -> MovedBones:
        """Return the bones of a muscle at values of the coordinates (`Articulation`).

        A skeleton of the right side moves a muscle of the left one as its mirror image, by the same
        values: a joint that lifts the right arm lifts the left one. So does one of the left a
        muscle of the right. A skeleton that states no side is of the muscle's own: its poses are
        taken as they are, its ground frame with x to the body's right on either side.

        Parameters
        ----------
        values
            (m, d) rad or m.
        bones
            The muscle's, which have to be those of the skeleton.
        side
            The muscle's.

        Returns
        -------
        MovedBones
            Poses and screws, right-shoulder form.

        Raises
        ------
        SkeletonError
            For other bones, and anything but finite numbers (m, d).
        """
        self.pack_for(bones)
        check_side(side)
        return self._move_as_right(self._as_values(values, 'values', batch=True), side)

    def pack_for(self, bones: Sequence[str]) -> Chain:
        """Return the chain as the kernels take it.

        Parameters
        ----------
        bones
            The muscle's: the ground first, then those that move.

        Returns
        -------
        Chain
            Of the bones that this skeleton is for.

        Raises
        ------
        SkeletonError
            For other bones than these.

        """
        if tuple(bones) != self.bones:
            raise self.tree.fault(
                f'for the bones {list_names(self.bones)}, the muscle has {list_names(bones)}; '
                'skeleton.for_bones(solver.bones) is for these'
            )
        return self._chain

    def _as_values(self, q: npt.ArrayLike, name: str = 'q', batch: bool = False) -> Floats:
        """Return values (d,), or (m, d), of the coordinates; an error but for finite numbers."""
        d = len(self.coordinates)
        expected = f'(m, {d})' if batch else f'({d},)'
        values = as_floats(name, q, expected)
        if batch and values.shape == (0,):
            values = values.reshape(0, d)
        if values.ndim != 1 + batch or values.shape[-1] != d:
            names = list_names(self.coordinates)
            raise SkeletonError(f'{name}: shape {values.shape} given, {expected} expected: {names}')
        if not np.isfinite(values).all():
            i = int(np.argwhere(~np.isfinite(values))[0][-1])
            raise SkeletonError(f'{name}: {self.coordinates[i]} is not a finite number')
        return values

    def _move(self, values: Floats) -> MovedBones:
        """Return the bones of the side that the skeleton is of."""
        (m, d), k = values.shape, len(self.bones) - 1
        moved = MovedBones(np.empty((m, k, 3, 4)), np.empty((m, d, k, 6)))
        pose_bones(*self._chain, values, *moved)
        return moved

    def _move_as_right(self, values: Floats, side: str) -> MovedBones:
        """Return the bones of a muscle of a side, right-shoulder form."""
        moved = self._move(values)
        if (self.side or side) == 'left':
            return MovedBones(mirror_poses(moved.poses), mirror_screws(moved.screws))
        return moved

    def _move_for(self, values: Floats, side: str) -> MovedBones:
        """Return poses as a solver takes them and screws as its wrenches are; by no side, plain."""
        if side == '':
            return self._move(values)
        check_side(side)
        poses, screws = self._move_as_right(values, side)
        return MovedBones(poses, mirror_screws(screws) if side == 'left' else screws)

    @cached_property
    def _from_root(self) -> Skeleton:
        """The same tree with the root as the ground, and the ground as the bone that moves."""
        root = self.tree.root
        links = root, self.links[0]
        return Skeleton(self.tree, ('root', 'ground'), links, places=(self.origin,))

    @cached_property
    def _chain(self) -> Chain:
        """The tree as the kernel takes it, with the bones' frames in their links."""
        chain = pack_tree(self.tree, self.links)
        chain.frames[0] = place_in_link(*self.origin)
        if self.rest is not None:
            k, values = len(self.bones) - 1, np.array([self.rest])
            poses = np.empty((1, k, 3, 4))
            pose_bones(*chain, values, poses, np.empty((1, len(self.rest), k, 6)))
            for i, (R, t) in enumerate(zip(poses[0, :, :, :3], poses[0, :, :, 3], strict=True)):
                chain.frames[i + 1] = np.column_stack([R.T, -R.T @ t])
        for i, place in enumerate(self.places):
            if place is not None:
                chain.frames[i + 1] = place_in_link(*place)
        return chain


def _as_origin(origin: Origin) -> Origin:
    """Return a place of a frame as floats; SkeletonError for anything else."""
    try:
        xyz, rpy = origin
    except (TypeError, ValueError):
        expected = '((x, y, z), (roll, pitch, yaw)) expected'
        raise SkeletonError(f'origin: {describe_value(origin)} given, {expected}') from None
    return as_triple('origin: xyz', xyz, 'm'), as_triple('origin: rpy', rpy, 'rad')


def bundled_skeletons() -> dict[str, str]:
    """Return the texts of the skeletons that come with the package, by name."""
    folder = resources.files('linkedplane_ros') / 'models'
    return {
        entry.name.removesuffix('.urdf'): entry.read_text(encoding='utf-8')
        for entry in folder.iterdir()
        if entry.name.endswith('.urdf')
    }


def parse_bone_links(entries: Iterable[str]) -> dict[str, str]:
    """Return the links of bones from entries BONE:=LINK, as the parameter `bone_links` has them."""
    return parse_pairs('bone_links', 'BONE:=LINK', entries)


def parse_pairs(name: str, form: str, entries: Iterable[str]) -> dict[str, str]:
    """Return what entries of a form, as BONE:=LINK, say; SkeletonError, with the name, for others.

    No first part may be given twice.
    """
    pairs: dict[str, str] = {}
    for text in entries:
        if not isinstance(text, str):
            raise SkeletonError(f'{name}: {describe_value(text)} given, {form} expected')
        first, given, second = (part.strip() for part in text.partition(':='))
        if not (first and given and second):
            raise SkeletonError(f'{name}: {describe_value(text)} given, {form} expected')
        if first in pairs:
            what = form.partition(':=')[0].lower()
            raise SkeletonError(f'{name}: {what} {describe_value(first)} is given twice')
        pairs[first] = second
    return pairs
