"""A broad muscle: its bands, obstacle spheres and linked planes, loaded from a YAML model file.

The file's polynomials are evaluated and its units converted here and nowhere else: everything
behind a BroadMuscle is in m and rad.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import yaml

Floats = npt.NDArray[np.float64]

FORMAT = 'linkedplane_ros/broad_muscle'
VERSION = 1
METRES = {'m': 1.0, 'cm': 1e-2, 'mm': 1e-3}
RADIANS = {'rad': 1.0, 'deg': math.pi / 180.0}
PARALLEL = 1e-6  # sine of the smallest angle between a reference normal and the first band


class ModelError(ValueError):
    """A model file that cannot be used; the message names the file, the key and the reason."""


@dataclass(frozen=True)
class Head:
    """A part of the muscle: its bands and the one that stands for it in comparisons."""

    name: str
    bands: tuple[str, ...]
    represented_by: str


@dataclass(frozen=True, eq=False)
class BroadMuscle:
    """A broad muscle of n linked bands, right shoulder, in m and rad (thesis ch. 5)."""

    name: str
    source: str
    band_names: tuple[str, ...]
    heads: tuple[Head, ...]
    origins: Floats
    """(n, 3) ground (scapula) frame."""
    insertions: Floats
    """(n, 3) humerus frame."""
    sphere_centres: Floats
    """(n, 3) each in its band's moving frame."""
    sphere_radii: Floats
    """(n,)"""
    ground_point: Floats
    """(3,) SC, ground frame: the moving frames' z axes stand across the plane with it."""
    humeral_point: Floats
    """(3,) HM, humerus frame: the moving frames' x axes point to it."""
    plane_angles: Floats
    """(n,) phi, from the plane of the band before; the first is replaced by theta."""
    reference_normal: Floats
    """(3,) N, ground frame, unit."""
    interference_centres: Floats
    """(k, 3) ground frame."""
    interference_radii: Floats
    """(k,)"""
    interference_names: tuple[str, ...]
    range_of_motion: tuple[tuple[float, float], ...] | None = None
    """Lowest and highest flexion, abduction and rotation that the model is for, rad."""

    @staticmethod
    def load(name: str | Path) -> BroadMuscle:
        """Load a bundled model by its name, or a .yaml file by its path.

        Raises ModelError (a ValueError) with one line that names the file, the key and the reason.
        """
        bundled = bundled_models()
        text = str(name)
        if text in bundled:
            return _read(text, bundled[text])
        path = Path(text)
        if path.suffix not in ('.yaml', '.yml'):
            raise ModelError(
                f'muscle: {text!r} is neither a bundled model ({", ".join(sorted(bundled))}) '
                'nor a path to a .yaml file'
            )
        try:
            content = path.read_text(encoding='utf-8')
        except UnicodeDecodeError:
            raise ModelError(f'{path}: cannot be read: not UTF-8 text') from None
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise ModelError(f'{path}: cannot be read: {reason}') from None
        return _read(text, content)

    def outside(self, rotations: Floats) -> int:
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

    def head_of(self, band: str) -> str:
        """Return the name of the head that a band belongs to."""
        return next(head.name for head in self.heads if band in head.bands)


def bundled_models() -> dict[str, str]:
    """Return the texts of the model files that come with the package, by name."""
    folder = resources.files('linkedplane_ros') / 'models'
    return {
        entry.name.removesuffix('.yaml'): entry.read_text(encoding='utf-8')
        for entry in folder.iterdir()
        if entry.name.endswith('.yaml')
    }


class UniqueKeys(yaml.SafeLoader):
    """YAML in which no key of a mapping may stand twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Return the mapping; a YAML error at the second of two like keys."""
        keys = set()
        for key_node, _ in node.value:
            key = key_node.value if isinstance(key_node, yaml.ScalarNode) else None
            if key in keys:
                problem = f'the key {key!r} stands twice'
                raise yaml.MarkedYAMLError(problem=problem, problem_mark=key_node.start_mark)
            keys.add(key)
        return super().construct_mapping(node, deep)


def _read(file: str, text: str) -> BroadMuscle:
    try:
        content = yaml.load(text, UniqueKeys)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        mark = getattr(error, 'problem_mark', None)
        line = f' at line {mark.line + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or str(error).split('\n')[0]
        raise ModelError(f'{file}: not valid YAML{line}: {problem}') from None
    return _muscle(Section(file, '', content))


class Section:
    """A mapping of a model file that knows where it stands; every fault names its key."""

    def __init__(self, file: str, path: str, content: Any) -> None:
        """Hold a mapping; ModelError for anything else."""
        self.file, self.path = file, path
        if not isinstance(content, Mapping):
            where = path or 'the file'
            raise ModelError(f'{file}: {where}: a mapping of keys expected, {_kind(content)} given')
        self.content = content

    def fault(self, key: str, reason: str) -> ModelError:
        """Return the error for one of the section's keys."""
        return ModelError(f'{self.file}: {self.key(key)}: {reason}')

    def key(self, key: str) -> str:
        """Return the full, dotted name of a key."""
        shown = key if key.isprintable() else repr(key)
        return f'{self.path}.{shown}' if self.path else shown

    def allow(self, required: Iterable[str], optional: Iterable[str] = ()) -> None:
        """Refuse missing and unknown keys."""
        required, optional = list(required), list(optional)
        for key in required:
            if key not in self.content:
                raise self.fault(key, 'missing')
        for key in self.content:
            if key not in required + optional:
                known = ', '.join(required + optional)
                raise self.fault(str(key), f'unknown key; known here: {known}')

    def section(self, key: str) -> Section:
        """Return the mapping under a key."""
        return Section(self.file, self.key(key), self.content[key])

    def text(self, key: str) -> str:
        """Return the non-empty text under a key."""
        value = self.content[key]
        if not isinstance(value, str) or not value.strip():
            raise self.fault(key, f'text expected, {_kind(value)} given')
        return value.strip()

    def token(self, key: str) -> str:
        """Return the text under a key that is to be part of topic names."""
        value = self.text(key)
        if not re.fullmatch(r'[A-Za-z][A-Za-z0-9_]*', value):
            raise self.fault(key, f'{value!r} given; a letter, then letters, digits and _ expected')
        return value

    def names(self, key: str) -> tuple[str, ...]:
        """Return the list of distinct names under a key."""
        value = self.content[key]
        if not isinstance(value, list) or not value or not all(isinstance(v, str) for v in value):
            raise self.fault(key, f'a list of names expected, {_kind(value)} given')
        if len(set(value)) < len(value):
            raise self.fault(key, 'a name stands twice')
        for name in value:
            if not name.isprintable() or ',' in name or not name.strip():
                raise self.fault(key, f'{name!r} given; a name without a comma expected')
        return tuple(value)

    def choice(self, key: str, factors: Mapping[str, float]) -> float:
        """Return the factor that a unit's name stands for."""
        value = self.content[key]
        if not isinstance(value, str) or value not in factors:
            raise self.fault(key, f'{value!r} given, one of {", ".join(factors)} expected')
        return factors[value]

    def number(self, key: str) -> float:
        """Return the finite number under a key."""
        return self._number(key, self.content[key])

    def numbers(self, key: str, count: int | None = None) -> Floats:
        """Return the list of finite numbers under a key, `count` of them if that is given."""
        value = self.content[key]
        expected = f'a list of {count} numbers' if count else 'a list of numbers'
        if not isinstance(value, list) or not value or (count and len(value) != count):
            given = f'a list of {len(value)}' if isinstance(value, list) else _kind(value)
            raise self.fault(key, f'{expected} expected, {given} given')
        return np.array([self._number(f'{key}[{i}]', v) for i, v in enumerate(value)])

    def polynomial(self, key: str, s: Floats) -> Floats:
        """Return the polynomial under a key (highest power first) at each s."""
        with np.errstate(all='ignore'):
            values = np.asarray(np.polyval(self.numbers(key), s), dtype=np.float64)
        if not np.isfinite(values).all():
            raise self.fault(key, 'the polynomial is not finite over s')
        return values

    def curve(self, key: str, s: Floats) -> Floats:
        """Return the (n, 3) points of the x, y and z polynomials under a key."""
        points = self.section(key)
        points.allow(('x', 'y', 'z'))
        return np.column_stack([points.polynomial(axis, s) for axis in 'xyz'])

    def _number(self, key: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            hint = '; write 1.0e-3, not 1e-3' if isinstance(value, str) and 'e' in value else ''
            raise self.fault(key, f'a number expected, {value!r} given{hint}')
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self.fault(key, f'a finite number expected, {number} given')
        return number


def _kind(value: Any) -> str:
    if value is None:
        return 'nothing'
    kinds: dict[Any, str] = {dict: 'a mapping', list: 'a list', str: 'text'}
    return kinds.get(type(value), repr(value))


def _muscle(file: Section) -> BroadMuscle:
    file.allow(
        (
            'format', 'version', 'name', 'source', 'units', 'bands', 'heads', 'origin',
            'insertion', 'sphere', 'plane_angle', 'reference_normal',
        ),
        ('interference_spheres', 'range_of_motion'),
    )  # fmt: skip
    if file.text('format') != FORMAT:
        raise file.fault('format', f'{file.content["format"]!r} given, {FORMAT!r} expected')
    if file.content['version'] is not VERSION:
        raise file.fault('version', f'{file.content["version"]!r} given, {VERSION} expected')
    units = file.section('units')
    units.allow(('length', 'angle'))
    metres, radians = units.choice('length', METRES), units.choice('angle', RADIANS)
    bands = file.section('bands')
    bands.allow(('s', 'names'))
    names = bands.names('names')
    span = bands.section('s')
    span.allow(('first', 'last'))
    s = np.linspace(span.number('first'), span.number('last'), len(names))
    sphere = file.section('sphere')
    sphere.allow(('centre', 'radius', 'ground_point', 'humeral_point'))
    inter_names, inter_centres, inter_radii = _interference(file, metres)
    normal = file.numbers('reference_normal', 3)
    if not np.linalg.norm(normal) > 0.0:
        raise file.fault('reference_normal', 'a vector of some length expected, zero given')
    muscle = BroadMuscle(
        name=file.token('name'),
        source=file.text('source'),
        band_names=names,
        heads=_heads(file, names),
        origins=file.curve('origin', s) * metres,
        insertions=file.curve('insertion', s) * metres,
        sphere_centres=sphere.curve('centre', s) * metres,
        sphere_radii=sphere.polynomial('radius', s) * metres,
        ground_point=sphere.numbers('ground_point', 3) * metres,
        humeral_point=sphere.numbers('humeral_point', 3) * metres,
        plane_angles=file.polynomial('plane_angle', s) * radians,
        reference_normal=normal / np.linalg.norm(normal),
        interference_centres=inter_centres,
        interference_radii=inter_radii,
        interference_names=inter_names,
        range_of_motion=_range_of_motion(file, radians),
    )
    _check(file, muscle)
    return muscle


def _heads(file: Section, names: tuple[str, ...]) -> tuple[Head, ...]:
    section = file.section('heads')
    heads = []
    left = list(names)
    for name in section.content:
        entry = section.section(name)
        entry.allow(('bands', 'represented_by'))
        bands, one = entry.names('bands'), entry.text('represented_by')
        for band in bands:
            if band not in left:
                raise entry.fault('bands', f'{band!r} is no band, or one of another head')
            left.remove(band)
        if one not in bands:
            raise entry.fault('represented_by', f'{one!r} is not one of the bands of the head')
        heads.append(Head(str(name), bands, one))
    if left:
        raise file.fault('heads', f'no head has the band {left[0]!r}')
    return tuple(heads)


def _interference(file: Section, metres: float) -> tuple[tuple[str, ...], Floats, Floats]:
    names: list[str] = []
    centres: list[Floats] = []
    radii: list[float] = []
    if 'interference_spheres' in file.content:
        section = file.section('interference_spheres')
        for name in section.content:
            entry = section.section(name)
            entry.allow(('centre', 'radius'))
            names.append(str(name))
            centres.append(entry.numbers('centre', 3) * metres)
            radii.append(entry.number('radius') * metres)
            if radii[-1] <= 0.0:
                raise entry.fault('radius', f'{entry.number("radius"):g} given, > 0 expected')
    return tuple(names), np.array(centres).reshape(-1, 3), np.array(radii)


def _range_of_motion(file: Section, radians: float) -> tuple[tuple[float, float], ...] | None:
    if 'range_of_motion' not in file.content:
        return None
    section = file.section('range_of_motion')
    coordinates = ('flexion', 'abduction', 'rotation')
    section.allow(coordinates)
    limits = []
    for coordinate in coordinates:
        low, high = (section.numbers(coordinate, 2) * radians).tolist()
        if low > high:
            raise section.fault(coordinate, 'the lowest, then the highest angle expected')
        limits.append((low, high))
    return tuple(limits)


def _check(file: Section, muscle: BroadMuscle) -> None:
    """Refuse what has no geometry: a radius that is not positive, a band without a plane."""
    for name, radius in zip(muscle.band_names, muscle.sphere_radii, strict=True):
        if radius <= 0.0:
            raise file.fault(
                'sphere.radius', f'{radius:.6g} m for band {name}, a radius > 0 expected'
            )
    lines = muscle.insertions - muscle.origins
    for name, line in zip(muscle.band_names, lines, strict=True):
        if not np.linalg.norm(line) > 1e-9:
            raise file.fault('insertion', f'band {name} ends where it begins (arm at the side)')
    across = np.cross(muscle.reference_normal, lines[0] / np.linalg.norm(lines[0]))
    if np.linalg.norm(across) < PARALLEL:
        raise file.fault(
            'reference_normal',
            f'parallel to the first band, {muscle.band_names[0]} (arm at the side): its plane '
            'is undefined',
        )
    for name, origin in zip(muscle.band_names, muscle.origins, strict=True):
        towards = np.cross(muscle.humeral_point - origin, muscle.ground_point - origin)
        if not np.linalg.norm(towards) > 1e-9:
            raise file.fault(
                'sphere.ground_point',
                f"in line with humeral_point and the origin of band {name}: the sphere's frame "
                'is undefined',
            )
