# SPDX-License-Identifier: Apache-2.0
"""A broad muscle: its bands, obstacle spheres and linked planes, in m and rad."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FieldError, ModelError, describe_value
from ..files import replace_when_complete
from ..types import Floats, Interval
from . import file, scaling, writing
from .bones import BALL_JOINT, Bones
from .definition import (
    Definition,
    check_bones,
    define_in_metres,
    expand_frame,
    require_frame,
    unit_vector,
)
from .parts import COORDINATES, Head, Landmark, whole_head
from .range_of_motion import find_in_range
from .scaling import Scale
from .validity import (
    check_distinct,
    check_geometry,
    check_heads,
    check_landmarks,
    check_names,
    check_size,
    check_topic_name,
    require_array,
    require_intervals,
    require_items,
    require_text,
)
from .yaml_mapping import YamlMapping, parse_yaml, read_yaml

__all__ = ['BroadMuscle', 'Head', 'Landmark', 'ModelError', 'Scale']


SHAPES: dict[str, tuple[str | int, ...]] = {
    'origins': ('n', 3),
    'insertions': ('n', 3),
    'sphere_centres': ('n', 3),
    'sphere_radii': ('n',),
    'ground_point': (3,),
    'humeral_point': (3,),
    'plane_angles': ('n',),
    'reference_normal': (3,),
    'interference_centres': ('k', 3),
    'interference_radii': ('k',),
}


@dataclass(frozen=True, eq=False, kw_only=True)
class BroadMuscle:
    """A broad muscle of n linked bands (thesis ch. 4 and 5), in m and rad.

    The right shoulder's; the left one's is its mirror image. Arrays are copied, and read-only.
    Two muscles are equal if their files would state the same.

    Raises
    ------
    ModelError
        Where a field cannot be as it is, for the same reasons as a file is refused: it names the
        field, the value, and what is expected.

    """

    name: str
    """A letter, then letters, digits and _: the node's topics begin with it."""
    source: str
    """Where the numbers come from."""
    band_names: tuple[str, ...]
    """(n) in the order in which the bands' planes are linked."""
    heads: tuple[Head, ...] = ()
    """Without any, the muscle is its own only head."""
    origins: Floats
    """(n, 3) m, each in the frame of its bone: the scapula, if `bones` does not say otherwise."""
    insertions: Floats
    """(n, 3) m, each in the frame of its bone: the humerus, as above."""
    sphere_centres: Floats
    """(n, 3) m, each in its `sphere_frame`."""
    sphere_radii: Floats
    """(n,) m, above zero."""
    ground_point: Floats | None = None
    """(3,) m, SC, frame of its bone (the ground): z axes of moving frames are normal to the plane
    through the band's origin, `humeral_point` and this point. None without a moving frame."""
    humeral_point: Floats | None = None
    """(3,) m, HM, frame of its bone (the humerus): x axes of moving frames point to it. None
    without a moving frame."""
    plane_angles: Floats
    """(n,) rad, phi: the angle of each plane from that of the band before; in place of the first
    one the solver finds theta."""
    reference_normal: Floats
    """(3,) N, frame of its bone (the ground): theta is measured from the plane with this normal.
    Given at any length, kept at length 1."""
    interference_centres: Floats = field(default_factory=lambda: np.empty((0, 3)))
    """(k, 3) m, each in the frame of its bone: spheres of bone that no band should enter."""
    interference_radii: Floats = field(default_factory=lambda: np.empty(0))
    """(k,) m, above zero."""
    interference_names: tuple[str, ...] = ()
    """(k)"""
    interference_bones: tuple[str, ...] = ()
    """(k) the bones of these spheres; empty where all are on the ground."""
    range_of_motion: tuple[Interval, ...] | None = None
    """rad, the lowest and highest flexion, abduction and rotation that the model is for."""
    sphere_frame: str | tuple[str, ...] = 'moving'
    """What the spheres move with, one for all or (n) one for each band: the scapula (`ground`), a
    bone that moves (`humerus`), or a frame of the band's own (`moving`), which needs SC and HM."""
    bones: Bones = BALL_JOINT
    """The bones, and which of them the points belong to."""
    licence: str = ''
    """What others may do with the model."""
    landmarks: tuple[Landmark, ...] = ()
    """Places on the bones that can be found on a subject, m."""
    stated: Definition | None = field(default=None, repr=False)
    """What the muscle's file states. Ignored where another field has been changed since."""

    def __post_init__(self) -> None:
        """Check all fields, as a file's are; FieldError names the field."""
        if not isinstance(self.stated, (Definition, type(None))):
            raise FieldError(
                'stated', f'{describe_value(self.stated)} given, a Definition expected'
            )
        check_topic_name('name', self.name)
        self._set('source', require_text('source', self.source))
        if self.licence != '':
            self._set('licence', require_text('licence', self.licence))
        if not isinstance(self.bones, Bones):
            raise FieldError('bones', f'{describe_value(self.bones)} given, Bones expected')
        for name in ('band_names', 'interference_names', 'interference_bones'):
            self._set(name, require_items(name, getattr(self, name), str))
        check_names('band_names', self.band_names)
        check_distinct('interference_names', self.interference_names)
        heads = require_items('heads', self.heads, Head)
        self._set('heads', heads or (whole_head(self.name, self.band_names),))
        check_heads(self.heads, self.band_names)
        self._set('landmarks', require_items('landmarks', self.landmarks, Landmark))
        check_landmarks(self.landmarks)
        self._set_bones()
        if self.range_of_motion is not None:
            limits = require_intervals('range_of_motion', self.range_of_motion, COORDINATES)
            self._set('range_of_motion', limits)
        self._set_arrays()
        check_geometry(self)

    def _set_bones(self) -> None:
        """Check what the points belong to."""
        n, k = len(self.band_names), len(self.interference_names)
        self.bones.check_count(n)
        check_bones(self.bones, self.landmarks, 'landmarks')
        bones = self.interference_bones
        if len(bones) not in (0, k):
            reason = f'{len(bones)} given, {k} expected, one for each interference sphere'
            raise FieldError('interference_bones', reason)
        for i, bone in enumerate(bones):
            self.bones.require(f'interference_bones[{i}]', bone)
        if set(bones) == {self.bones.ground}:
            self._set('interference_bones', ())
        frame = require_frame('sphere_frame', self.sphere_frame, n, self.bones.frames)
        self._set('sphere_frame', frame)

    def _set_arrays(self) -> None:
        """Take copies of the arrays, and check them; no SC and no HM without a moving frame."""
        sizes = {'n': len(self.band_names), 'k': len(self.interference_names)}
        moving = 'moving' in self.sphere_frames
        for name, shape in SHAPES.items():
            if name in ('ground_point', 'humeral_point') and not moving:
                self._set(name, None)
                continue
            expected = tuple(sizes[size] if isinstance(size, str) else size for size in shape)
            array = require_array(name, getattr(self, name), expected)
            if name == 'reference_normal':
                array = unit_vector(array)
            else:
                check_size(name, array, 'rad' if name == 'plane_angles' else 'm')
            array.flags.writeable = False  # or it would differ from the definition
            self._set(name, array)

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    @staticmethod
    def load(name: str | Path) -> BroadMuscle:
        """Return a bundled model, or the model in a file.

        Parameters
        ----------
        name
            The name of a bundled model, or the path of a .yaml file
            (doc/reference/model_format.md).

        Returns
        -------
        BroadMuscle
            In m and rad, with the file's polynomials and units in its `definition`.

        Raises
        ------
        ModelError
            One line that names the file, the key and the reason.

        """
        bundled = file.bundled_models()
        text = str(name)
        if text in bundled:
            return build_muscle(parse_yaml(text, bundled[text]))
        path = Path(text)
        if path.suffix not in ('.yaml', '.yml'):
            raise ModelError(
                f'muscle: {describe_value(text)} is neither a bundled model '
                f'({", ".join(sorted(bundled))}) nor a path to a .yaml file'
            )
        return build_muscle(read_yaml(path))

    @staticmethod
    def from_definition(definition: Definition) -> BroadMuscle:
        """Return the muscle that a definition defines.

        Parameters
        ----------
        definition
            What a file states, in its own units.

        Returns
        -------
        BroadMuscle
            In m and rad; its `definition` is the one given.

        Raises
        ------
        ModelError
            Where the numbers do not make a muscle; it names the field.

        """
        return BroadMuscle(**definition.muscle_fields, stated=definition)

    @cached_property
    def definition(self) -> Definition:
        """What the muscle's file states, or would state.

        Of a muscle read from a file, polynomials and units are those of the file; a muscle made or
        changed in Python has lists of numbers, in m and rad.
        """
        mine = {each.name: getattr(self, each.name) for each in fields(self)}
        stated = mine.pop('stated')
        if stated is not None and all(
            are_equal(value, stated.muscle_fields[name]) for name, value in mine.items()
        ):
            return stated  # type: ignore[no-any-return]
        return define_in_metres(mine)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, BroadMuscle) and self.definition == other.definition

    def __hash__(self) -> int:
        return hash(self.definition)

    def scaled(self, scale: float | str | Path | Sequence[float] | Scale) -> BroadMuscle:
        """Return the muscle at a subject's size.

        Lengths and moment arms follow. Points scale along the axes of their bone from the centre of
        the joint, spheres stay spheres, plane angles stay as they are.

        Parameters
        ----------
        scale
            A factor; 3 of them, along x, y and z of both bones; 6, the scapula's and then the
            humerus's; the same as text, with commas; or the path of a subject's measurements,
            .yaml (doc/reference/model_format.md).

        Returns
        -------
        BroadMuscle
            In m and rad; its `source` says the scale. At a scale of 1 an equal muscle.

        Raises
        ------
        ModelError
            Where the scale is none of these, or the measurements do not suit the model.

        """
        wanted = scaling.parse_scale(scale, self.definition)
        return BroadMuscle.from_definition(scaling.scale_definition(self.definition, wanted))

    @property
    def coefficients(self) -> dict[str, float]:
        """Every number of the definition's geometry by its place, as `sphere.centre.x[0]`.

        In the definition's units. A number that is common to all bands has no index
        (`plane_angle`).
        """
        return writing.coefficients(self.definition)

    def with_coefficients(self, values: Mapping[str, float]) -> BroadMuscle:
        """Return the muscle with other numbers in some places.

        Parameters
        ----------
        values
            The numbers by their places, as in `coefficients`, in the definition's units.

        Returns
        -------
        BroadMuscle
            In m and rad; everything else is as before.

        Raises
        ------
        ModelError
            For a place that the muscle does not have, and for numbers that cannot be.

        """
        return build_muscle(writing.replace_coefficients(self.definition, values))

    def to_yaml(self, path: str | Path) -> None:
        """Write the muscle as a .yaml file; `load` gives an equal muscle back, to the bit.

        Parameters
        ----------
        path
            Where to write; a file that is there is replaced when the new one is complete.

        Raises
        ------
        ModelError
            Where the file cannot be written, or `load` would read something else.

        """
        path = Path(path)
        if path.suffix not in ('.yaml', '.yml'):
            raise ModelError(f'{path}: a model file ends in .yaml')
        text = writing.yaml_text(self.definition)
        if file.read_definition(parse_yaml(str(path), text)) != self.definition:
            raise ModelError(f'{path}: not written: a name or text would be read otherwise')
        with replace_when_complete(path, ModelError) as part:
            part.write_text(text, encoding='utf-8')

    def count_outside_range(self, rotations: Floats, margin: float = 0.0) -> int:
        """Return how many rotations lie outside the range of motion.

        A rotation is outside if every triple of flexion, abduction and rotation that gives it is.

        Parameters
        ----------
        rotations
            (m, 3, 3) humerus -> scapula, right-shoulder form.
        margin
            rad, by which the range is widened at each end.

        Returns
        -------
        int
            0 to m; 0 for a muscle without a range of motion.

        """
        if self.range_of_motion is None:
            return 0
        wider = [(low - margin, high + margin) for low, high in self.range_of_motion]
        return int((~find_in_range(rotations, wider)).sum())

    @property
    def sphere_frames(self) -> tuple[str, ...]:
        """(n) what each band's sphere moves with: `moving`, `ground` or a bone that moves."""
        return expand_frame(self.sphere_frame, len(self.band_names))

    @property
    def bones_of_interference(self) -> tuple[str, ...]:
        """(k) the bone of each interference sphere."""
        return self.interference_bones or (self.bones.ground,) * len(self.interference_names)

    @property
    def has_ball_joint(self) -> bool:
        """Whether only the last bone's insertions, and HM, move where that bone alone does."""
        return self.bones.have_ball_joint(self.sphere_frames)

    def require_ball_joint(self, what: str) -> None:
        """Refuse the muscle for something that knows only the bones of one ball joint.

        Parameters
        ----------
        what
            That something, for the message.

        Raises
        ------
        ModelError
            Unless only insertions, HM and obstacle spheres are on the last bone.

        """
        joint = self.bones.joint
        if not self.has_ball_joint or joint in self.bones_of_interference:
            raise ModelError(
                f'{self.name}: {what} takes a muscle of one ball joint, which has all insertions '
                f'and HM on {joint}, and no origin, SC, N or interference sphere there'
            )

    def bands_by_sphere(self) -> dict[int, list[int]]:
        """Return which bands share an obstacle sphere.

        Bands share a sphere if it stands on a bone, and its centre and radius are the same.

        Returns
        -------
        dict
            For each sphere the numbers of its bands, from 0, by the first of them.

        """
        shared: dict[Any, list[int]] = {}
        radii, centres = self.sphere_radii.tolist(), self.sphere_centres.tolist()
        for i, frame in enumerate(self.sphere_frames):
            own = i if frame == 'moving' else None
            shared.setdefault((own, frame, radii[i], *centres[i]), []).append(i)
        return {bands[0]: bands for bands in shared.values()}

    def find_head(self, band: str) -> str:
        """Return the name of the head that a band belongs to.

        Parameters
        ----------
        band
            Its name, one of `band_names`.

        Returns
        -------
        str
            One of the names of `heads`.

        Raises
        ------
        ModelError
            For a name that no band has.

        """
        for head in self.heads:
            if band in head.bands:
                return head.name
        known = ', '.join(self.band_names)
        raise ModelError(f'{self.name}: band {describe_value(band)} given, one of {known} expected')


def build_muscle(content: YamlMapping) -> BroadMuscle:
    """Return the muscle that a file's content defines; ModelError names file and key."""
    with file.name_keys(content):
        return BroadMuscle.from_definition(file.read_definition(content))


def are_equal(one: Any, other: Any) -> bool:
    """Return whether two values of a field, arrays or not, are equal."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)
    return bool(one == other)
