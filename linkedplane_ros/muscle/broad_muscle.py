"""A broad muscle: its bands, obstacle spheres and linked planes, in m and rad."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ModelError
from ..files import replace_when_complete
from ..types import Floats, Interval
from . import file, scaling, writing
from .definition import (
    COORDINATES,
    Definition,
    Head,
    Landmark,
    Sphere,
    define_in_metres,
    expand_frame,
    require_frame,
    unit_vector,
    whole_head,
)
from .mapping import YamlMapping, parse_yaml, read_text
from .scaling import Scale
from .validity import (
    check_distinct,
    check_geometry,
    check_heads,
    check_landmarks,
    check_names,
    check_topic_name,
    require_array,
    require_intervals,
    require_text,
)

__all__ = ['BroadMuscle', 'Head', 'Landmark', 'ModelError', 'Scale', 'bundled_models']


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
    """A broad muscle of n linked bands, right shoulder, in m and rad (thesis ch. 4 and 5).

    Two muscles are equal if all that their files would state is.
    """

    name: str
    source: str
    band_names: tuple[str, ...]
    heads: tuple[Head, ...] = ()
    """Where none are given, the muscle is its own only head."""
    origins: Floats
    """(n, 3) ground (scapula) frame."""
    insertions: Floats
    """(n, 3) humerus frame."""
    sphere_centres: Floats
    """(n, 3) each in its `sphere_frame`."""
    sphere_radii: Floats
    """(n,)"""
    ground_point: Floats | None = None
    """(3,) SC, ground frame: the moving frames' z axes stand across the plane with it."""
    humeral_point: Floats | None = None
    """(3,) HM, humerus frame: the moving frames' x axes point to it."""
    plane_angles: Floats
    """(n,) phi, from the plane of the band before; the first is replaced by theta."""
    reference_normal: Floats
    """(3,) N, ground frame, unit."""
    interference_centres: Floats = field(default_factory=lambda: np.empty((0, 3)))
    """(k, 3) ground frame."""
    interference_radii: Floats = field(default_factory=lambda: np.empty(0))
    """(k,)"""
    interference_names: tuple[str, ...] = ()
    range_of_motion: tuple[Interval, ...] | None = None
    """Lowest and highest flexion, abduction and rotation that the model is for, rad."""
    sphere_frame: str | tuple[str, ...] = 'moving'
    """What the spheres move with, one for all or one for each band: their band's moving frame
    (`moving`: SC and HM are needed), the scapula (`ground`) or the humerus (`humerus`)."""
    licence: str = ''
    landmarks: tuple[Landmark, ...] = ()
    """Places on the bones that can be found on a subject, m."""
    stated: Definition | None = field(default=None, repr=False)
    """What a file states; of no account where the other fields have been changed since."""

    def __post_init__(self) -> None:
        """Check all that a file is checked for; FieldError names the field."""
        check_topic_name('name', self.name)
        self._set('source', require_text('source', self.source))
        self._set('licence', self.licence and require_text('licence', self.licence))
        for name in ('band_names', 'interference_names'):
            self._set(name, tuple(map(str, getattr(self, name))))
        check_names('band_names', self.band_names)
        check_distinct('interference_names', self.interference_names)
        heads = tuple(self.heads) or (whole_head(self.name, self.band_names),)
        self._set('heads', heads)
        check_heads(self.heads, self.band_names)
        self._set('landmarks', tuple(self.landmarks))
        check_landmarks([landmark.name for landmark in self.landmarks])
        if self.range_of_motion is not None:
            limits = require_intervals('range_of_motion', self.range_of_motion, COORDINATES)
            self._set('range_of_motion', limits)
        frame = require_frame('sphere_frame', self.sphere_frame, len(self.band_names))
        self._set('sphere_frame', frame)
        self._set_arrays()
        check_geometry(self)

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
            array = unit_vector(array) if name == 'reference_normal' else array
            array.flags.writeable = False  # the definition would no longer be theirs
            self._set(name, array)
        for sphere in zip(
            self.interference_names, self.interference_centres, self.interference_radii, strict=True
        ):
            Sphere(*sphere)  # which checks itself

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    @staticmethod
    def load(name: str | Path) -> BroadMuscle:
        """Load a bundled model by its name, or a .yaml file by its path.

        Raises ModelError (a ValueError) with one line that names the file, the key and the reason.
        """
        bundled = bundled_models()
        text = str(name)
        if text in bundled:
            return build_muscle(parse_yaml(text, bundled[text]))
        path = Path(text)
        if path.suffix not in ('.yaml', '.yml'):
            raise ModelError(
                f'muscle: {text!r} is neither a bundled model ({", ".join(sorted(bundled))}) '
                'nor a path to a .yaml file'
            )
        return build_muscle(parse_yaml(text, read_text(path)))

    @staticmethod
    def from_definition(definition: Definition) -> BroadMuscle:
        """Return the muscle that a definition defines."""
        return BroadMuscle(**definition.muscle_fields, stated=definition)

    @cached_property
    def definition(self) -> Definition:
        """What the muscle's file states, or would state.

        That of the file it was read from, polynomials and units as they stand there; for a muscle
        made or changed in Python, explicit lists in m and rad.
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
        """Return the muscle at a subject's size; lengths and moment arms follow.

        `scale` is a factor; 3 of them, along x, y and z of both bones; 6, the scapula's and then
        the humerus's; the same as text, with commas; or the path of a subject's measurements,
        .yaml (doc/reference/model_format.md). Raises ModelError where it is none of these.
        """
        wanted = scaling.parse_scale(scale, self.definition)
        return BroadMuscle.from_definition(scaling.scale_definition(self.definition, wanted))

    @property
    def coefficients(self) -> dict[str, float]:
        """Every number of the definition's geometry by its place, as `sphere.centre.x[0]`.

        In the definition's units; what is common to all bands has no index (`plane_angle`).
        """
        return writing.coefficients(self.definition)

    def with_coefficients(self, values: Mapping[str, float]) -> BroadMuscle:
        """Return the muscle with other numbers in these places; what `coefficients` names.

        Raises ModelError for a place that is not there, and where `load` would refuse the result.
        """
        return build_muscle(writing.replace_coefficients(self.definition, values))

    def to_yaml(self, path: str | Path) -> None:
        """Write the muscle as a .yaml file; `load` gives an equal muscle back, to the bit.

        A file that is there is replaced when the new one is complete. Raises ModelError where
        `load` would read something else, and where the file cannot be written.
        """
        path = Path(path)
        if path.suffix not in ('.yaml', '.yml'):
            raise ModelError(f'{path}: a model file ends in .yaml')
        text = writing.yaml_text(self.definition)
        if file.read_definition(parse_yaml(str(path), text)) != self.definition:
            raise ModelError(f'{path}: not written: a name or text would be read otherwise')
        with replace_when_complete(path, ModelError) as part:
            part.write_text(text, encoding='utf-8')

    def count_outside_range(self, rotations: Floats) -> int:
        """Return how many of the rotations (m, 3, 3) lie outside the range of motion.

        A rotation has two triples of flexion, abduction and rotation: one within is enough.
        """
        if self.range_of_motion is None:
            return 0
        R = rotations
        abduction = -np.arcsin(np.clip(R[:, 0, 2], -1.0, 1.0))
        flexion = np.arctan2(-R[:, 1, 2], R[:, 2, 2])
        rotation = np.arctan2(-R[:, 0, 1], R[:, 0, 0])
        within = np.zeros(len(R), dtype=bool)
        for angles in (
            (flexion, abduction, rotation),
            (flexion + np.pi, np.pi - abduction, rotation + np.pi),
        ):
            this = np.ones(len(R), dtype=bool)
            for angle, (low, high) in zip(angles, self.range_of_motion, strict=True):
                above = (angle - low + 1e-9) % (2.0 * np.pi)
                this &= above <= high - low + 2e-9
            within |= this
        return int((~within).sum())

    @property
    def sphere_frames(self) -> tuple[str, ...]:
        """(n) what each band's sphere moves with."""
        return expand_frame(self.sphere_frame, len(self.band_names))

    def bands_by_sphere(self) -> dict[int, list[int]]:
        """Return the bands of each sphere, by number, under the first of them.

        Bands share a sphere if it is on a bone and they have the same numbers.
        """
        shared: dict[Any, list[int]] = {}
        radii, centres = self.sphere_radii.tolist(), self.sphere_centres.tolist()
        for i, frame in enumerate(self.sphere_frames):
            own = i if frame == 'moving' else None
            shared.setdefault((own, frame, radii[i], *centres[i]), []).append(i)
        return {bands[0]: bands for bands in shared.values()}

    def find_head(self, band: str) -> str:
        """Return the name of the head that a band belongs to."""
        return next(head.name for head in self.heads if band in head.bands)


def build_muscle(content: YamlMapping) -> BroadMuscle:
    """Return the muscle that a file's content defines; ModelError names file and key."""
    with file.name_keys(content):
        return BroadMuscle.from_definition(file.read_definition(content))


def are_equal(one: Any, other: Any) -> bool:
    """Return whether two values of a field, arrays or not, are equal."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)
    return bool(one == other)


def bundled_models() -> dict[str, str]:
    """Return the texts of the model files that come with the package, by name."""
    folder = resources.files('linkedplane_ros') / 'models'
    return {
        entry.name.removesuffix('.yaml'): entry.read_text(encoding='utf-8')
        for entry in folder.iterdir()
        if entry.name.endswith('.yaml')
    }
