"""The model file (doc/reference/model_format.md): from YAML to a definition."""

from __future__ import annotations

import numpy as np

from ..types import Interval
from .definition import (
    BONES,
    COORDINATES,
    FRAMES,
    METRES,
    RADIANS,
    Curve,
    Curves,
    Definition,
    Head,
    Landmark,
    Listed,
    Polynomial,
    Span,
    Sphere,
    frames_of,
)
from .mapping import Section, kind_of, parsed

FORMAT = 'linkedplane_ros/broad_muscle'
VERSION = 1
JOINT_CENTRE = 'joint_centre'  # a landmark of both bones by itself
PARALLEL = 1e-6  # sine of the smallest angle between a reference normal and the first band

# The keys of every section, those needed and those that may be there; * stands for a name.
KEYS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    '': (
        (
            'format', 'version', 'name', 'source', 'units', 'bands', 'origin', 'insertion',
            'sphere', 'plane_angle', 'reference_normal',
        ),
        ('licence', 'heads', 'interference_spheres', 'landmarks', 'range_of_motion'),
    ),
    'units': (('length', 'angle'), ()),
    'bands': (('names',), ('s',)),
    'bands.s': (('first', 'last'), ()),
    'heads.*': (('bands', 'represented_by'), ()),
    'sphere': (('frame', 'centre', 'radius'), ('ground_point', 'humeral_point')),
    'interference_spheres.*': (('centre', 'radius'), ()),
    'landmarks.*': (('bone', 'at'), ()),
    'range_of_motion': (COORDINATES, ()),
    'curve': (('list',), ()),
    'curves': (('x', 'y', 'z'), ()),
}  # fmt: skip


def read(file: str, text: str) -> Definition:
    """Return the definition in a file's text; ModelError in one line for whatever is wrong."""
    return defined(parsed(file, text))


def defined(file: Section) -> Definition:
    """Return the definition in a file's content; ModelError in one line for whatever is wrong."""
    file.allow(*KEYS[''])
    if file.text('format') != FORMAT:
        raise file.fault('format', f'{file.content["format"]!r} given, {FORMAT!r} expected')
    if file.content['version'] is not VERSION:
        raise file.fault(
            'version',
            f'{file.content["version"]!r} given, {VERSION} expected: the version of the format '
            'that this program reads',
        )
    units = file.section('units')
    units.allow(*KEYS['units'])
    bands = file.section('bands')
    bands.allow(*KEYS['bands'])
    names = bands.names('names')
    n = len(names)
    sphere = file.section('sphere')
    frame = _frame(sphere, n)
    definition = Definition(
        name=file.token('name'),
        source=file.text('source'),
        licence=file.text('licence') if 'licence' in file else '',
        length=units.choice('length', METRES),
        angle=units.choice('angle', RADIANS),
        band_names=names,
        s=_s(bands, n),
        heads=_heads(file, names),
        origin=_points(file, 'origin', n),
        insertion=_points(file, 'insertion', n),
        sphere_frame=frame,
        sphere_centre=_points(sphere, 'centre', n),
        sphere_radius=_curve(sphere, 'radius', n),
        ground_point=sphere.point('ground_point') if 'ground_point' in sphere else None,
        humeral_point=sphere.point('humeral_point') if 'humeral_point' in sphere else None,
        plane_angle=_curve(file, 'plane_angle', n),
        reference_normal=file.point('reference_normal'),
        interference_spheres=interference_spheres(file),
        landmarks=_landmarks(file),
        range_of_motion=_range_of_motion(file),
    )
    _check(file, definition)
    return definition


def _s(bands: Section, n: int) -> Span | tuple[float, ...] | None:
    if 's' not in bands:
        return None
    if isinstance(bands.content['s'], list):
        return bands.numbers('s', n)
    span = bands.section('s')
    span.allow(*KEYS['bands.s'])
    return Span(span.number('first'), span.number('last'))


def _curve(section: Section, key: str, n: int) -> Curve:
    """Return what is a number, a polynomial's coefficients or, after `list`, n numbers."""
    value = section.content[key]
    if isinstance(value, list):
        return Polynomial(section.numbers(key))
    if isinstance(value, dict):
        listed = section.section(key)
        listed.allow(*KEYS['curve'])
        return Listed(listed.numbers('list', n))
    if isinstance(value, str) or value is None:
        raise section.fault(
            key,
            'a number, a list of numbers (coefficients in s) or {list: [...]} expected, '
            f'{kind_of(value)} given',
        )
    return Polynomial((section.number(key),))


def _points(section: Section, key: str, n: int) -> Curves:
    """Return what is a curve for each of x, y and z or, after `list`, n points."""
    points = section.section(key)
    if 'list' in points:
        points.allow(*KEYS['curve'])
        x, y, z = zip(*points.rows('list', n), strict=True)
        return Listed(x), Listed(y), Listed(z)
    points.allow(*KEYS['curves'])
    return _curve(points, 'x', n), _curve(points, 'y', n), _curve(points, 'z', n)


def _frame(sphere: Section, n: int) -> str | tuple[str, ...]:
    """Return what the spheres move with; SC and HM are for moving frames alone."""
    points = KEYS['sphere'][1]
    sphere.allow(*KEYS['sphere'])
    value = sphere.content['frame']
    frame: str | tuple[str, ...]
    if isinstance(value, list):
        if len(value) != n:
            raise sphere.fault(
                'frame', f'a list of {n} frames, one for each band, expected, {len(value)} given'
            )
        each = Section(sphere.file, sphere.path, {f'frame[{i}]': v for i, v in enumerate(value)})
        frame = tuple(each.choice(key, FRAMES) for key in each.content)
    else:
        frame = sphere.choice('frame', FRAMES)
    if 'moving' in frames_of(frame, n):
        sphere.allow(sum(KEYS['sphere'], ()))
    for key in points:
        if key in sphere and 'moving' not in frames_of(frame, n):
            raise sphere.fault(key, f'is for moving frames; the frame here is {value}')
    return frame


def _heads(file: Section, names: tuple[str, ...]) -> tuple[Head, ...]:
    """Return the heads; where none are named, one with the whole muscle."""
    if 'heads' not in file:
        return (whole(file.token('name'), names),)
    heads = []
    left = list(names)
    for name, entry in file.sections('heads'):
        entry.allow(*KEYS['heads.*'])
        bands, one = entry.names('bands'), entry.text('represented_by')
        for band in bands:
            if band not in left:
                raise entry.fault('bands', f'{band!r} is no band, or one of another head')
            left.remove(band)
        if one not in bands:
            raise entry.fault('represented_by', f'{one!r} is not one of the bands of the head')
        heads.append(Head(name, bands, one))
    if left:
        raise file.fault('heads', f'no head has the band {left[0]!r}')
    return tuple(heads)


def whole(name: str, bands: tuple[str, ...]) -> Head:
    """Return the muscle as its own only head, which its middle band stands for."""
    return Head(name, bands, bands[len(bands) // 2])


def interference_spheres(file: Section) -> tuple[Sphere, ...]:
    """Return the interference spheres of a file, in its unit of length."""
    spheres = []
    for name, entry in file.sections('interference_spheres'):
        entry.allow(*KEYS['interference_spheres.*'])
        sphere = Sphere(name, entry.point('centre'), entry.number('radius'))
        if sphere.radius <= 0.0:
            raise entry.fault('radius', f'{sphere.radius:g} given, > 0 expected')
        spheres.append(sphere)
    return tuple(spheres)


def _landmarks(file: Section) -> tuple[Landmark, ...]:
    landmarks = []
    for name, entry in file.sections('landmarks'):
        entry.allow(*KEYS['landmarks.*'])
        if name == JOINT_CENTRE:
            raise file.fault(f'landmarks.{name}', 'is the origin of both bones, and there already')
        landmarks.append(Landmark(name, entry.choice('bone', BONES), entry.point('at')))
    return tuple(landmarks)


def _range_of_motion(file: Section) -> tuple[Interval, Interval, Interval] | None:
    if 'range_of_motion' not in file:
        return None
    section = file.section('range_of_motion')
    section.allow(*KEYS['range_of_motion'])

    def limits(coordinate: str) -> Interval:
        low, high = section.numbers(coordinate, 2)
        if low > high:
            raise section.fault(coordinate, 'the lowest, then the highest angle expected')
        return low, high

    flexion, abduction, rotation = map(limits, COORDINATES)
    return flexion, abduction, rotation


def _check(file: Section, definition: Definition) -> None:
    """Refuse what has no geometry: a radius that is not positive, a band without a plane."""
    for key, curve in definition.curves().items():
        if definition.s is None and isinstance(curve, Polynomial) and curve.coefficients[1:]:
            raise file.fault('bands.s', f'missing; {key} is a polynomial in s')
        if not np.isfinite(definition.values[key]).all():
            raise file.fault(key, 'the polynomial is not finite over s')
    if not np.linalg.norm(definition.reference_normal) > 0.0:
        raise file.fault('reference_normal', 'a vector of some length expected, zero given')
    fields = definition.evaluated
    names, origins, radii = fields['band_names'], fields['origins'], fields['sphere_radii']
    for i in np.flatnonzero(radii <= 0.0):
        raise file.fault(
            'sphere.radius', f'{radii[i]:.6g} m for band {names[i]}, a radius > 0 expected'
        )
    lines = fields['insertions'] - origins
    sizes = np.linalg.norm(lines, axis=1)
    for i in np.flatnonzero(~(sizes > 1e-9)):
        raise file.fault('insertion', f'band {names[i]} ends where it begins (arm at the side)')
    across = np.cross(fields['reference_normal'], lines[0] / sizes[0])
    if np.linalg.norm(across) < PARALLEL:
        raise file.fault(
            'reference_normal',
            f'parallel to the first band, {names[0]} (arm at the side): its plane is undefined',
        )
    moving = np.array(frames_of(definition.sphere_frame, len(names))) == 'moving'
    if not moving.any():
        return
    towards = np.cross(fields['humeral_point'] - origins, fields['ground_point'] - origins)
    for i in np.flatnonzero(moving & ~(np.linalg.norm(towards, axis=1) > 1e-9)):
        raise file.fault(
            'sphere.ground_point',
            f"in line with humeral_point and the origin of band {names[i]}: the sphere's frame is "
            'undefined',
        )
