# SPDX-License-Identifier: Apache-2.0
"""The model file (doc/reference/model_format.md): from YAML to a definition."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import resources

from ..errors import FieldError, describe_value
from ..types import Interval
from .bones import BALL_JOINT, Bones
from .definition import Definition
from .keys import FORMAT, KEYS_OF_FIELDS, VERSIONS, check_keys, known_keys
from .parts import (
    COORDINATES,
    Curve,
    Curves,
    Head,
    InterferenceSphere,
    Landmark,
    Listed,
    Polynomial,
    Span,
)
from .yaml_mapping import YamlMapping, describe_kind, is_version, number_hint


@contextmanager
def name_keys(mapping: YamlMapping) -> Iterator[None]:
    """Within the block, name file and key in place of the field that a model cannot have."""
    try:
        yield
    except FieldError as error:
        field, bracket, index = error.field.partition('[')
        key = KEYS_OF_FIELDS.get(field, field) + bracket + index
        raise mapping.fault(key, error.reason) from None


def read_definition(file: YamlMapping) -> Definition:
    """Return the definition in a file's content; ModelError names file, key and reason."""
    check_keys(file, '')
    if file.content['format'] != FORMAT:
        given = describe_value(file.content['format'])
        raise file.fault('format', f'{given} given, {FORMAT!r} expected')
    version = file.content['version']
    if not any(is_version(version, known) for known in VERSIONS):
        known = ' or '.join(map(str, VERSIONS))
        raise file.fault(
            'version',
            f'{describe_value(version)} given, {known} expected: the versions of the format that '
            'this program reads',
        )
    units = file.mapping('units')
    check_keys(units, 'units')
    bands = file.mapping('bands')
    check_keys(bands, 'bands')
    sphere = file.mapping('sphere')
    check_keys(sphere, 'sphere')
    frame = sphere.content['frame']
    with name_keys(file):
        bones = read_bones(file, version)
        if not isinstance(frame, list):
            sphere.choice('frame', bones.frames)
        return Definition(
            name=file.text('name'),
            source=file.text('source'),
            licence=file.text('licence') if 'licence' in file else '',
            length=units.content['length'],
            angle=units.content['angle'],
            band_names=bands.names('names'),
            s=_read_s(bands),
            heads=_read_heads(file),
            origin=_read_points(file, 'origin'),
            insertion=_read_points(file, 'insertion'),
            sphere_frame=tuple(frame) if isinstance(frame, list) else frame,
            sphere_centre=_read_points(sphere, 'centre'),
            sphere_radius=_read_curve(sphere, 'radius'),
            ground_point=sphere.point('ground_point') if 'ground_point' in sphere else None,
            humeral_point=sphere.point('humeral_point') if 'humeral_point' in sphere else None,
            plane_angle=_read_curve(file, 'plane_angle'),
            reference_normal=file.point('reference_normal'),
            interference_spheres=read_interference_spheres(file, version, bones.ground),
            landmarks=_read_landmarks(file),
            range_of_motion=_read_range_of_motion(file),
            bones=bones,
        )


def read_bones(file: YamlMapping, version: int) -> Bones:
    """Return the bones of a file; those of version 1 are scapula and humerus."""
    if version == 1:
        if 'bones' in file:
            raise file.fault('bones', 'unknown key in version 1; version: 2 has it')
        return BALL_JOINT
    if 'bones' not in file:
        raise file.fault('bones', 'missing')
    bones = file.mapping('bones')
    check_keys(bones, 'bones')
    given = {key: value for key, value in bones.content.items() if key != 'names'}
    for key, value in given.items():
        if value == '':
            raise bones.fault(key, "'' given, the name of a bone expected")
    return Bones(bones.names('names'), **given)


def _read_s(bands: YamlMapping) -> Span | tuple[float, ...] | None:
    if 's' not in bands:
        return None
    if isinstance(bands.content['s'], list):
        return bands.numbers('s')
    span = bands.mapping('s')
    check_keys(span, 'bands.s')
    return Span(span.number('first'), span.number('last'))


def _read_curve(mapping: YamlMapping, key: str) -> Curve:
    """Return what is a number, a polynomial's coefficients or, after `list`, a list of numbers."""
    value = mapping.content[key]
    if isinstance(value, list):
        return Polynomial(mapping.numbers(key))
    if isinstance(value, dict):
        listed = mapping.mapping(key)
        check_keys(listed, 'QUANTITY')
        return Listed(listed.numbers('list'))
    if isinstance(value, str) or value is None:
        raise mapping.fault(
            key,
            'a number, a list of numbers (coefficients in s) or {list: [...]} expected, '
            f'{describe_kind(value)} given{number_hint(value)}',
        )
    return Polynomial((mapping.number(key),))


def _read_points(mapping: YamlMapping, key: str) -> Curves:
    """Return what is a curve for each of x, y and z or, after `list`, a list of points."""
    points = mapping.mapping(key)
    axes, whole = known_keys('POINTS')
    if 'list' in points:
        points.check_keys(whole)
        x, y, z = zip(*points.points('list'), strict=True)
        return Listed(x), Listed(y), Listed(z)
    points.check_keys(axes)
    return _read_curve(points, 'x'), _read_curve(points, 'y'), _read_curve(points, 'z')


def _read_heads(file: YamlMapping) -> tuple[Head, ...]:
    if 'heads' in file and file.content['heads'] == {}:
        raise file.fault('heads', 'at least one head expected, none given')
    heads = []
    for name, entry in file.mappings('heads'):
        check_keys(entry, 'heads.NAME')
        with name_keys(entry):
            heads.append(Head(name, entry.names('bands'), entry.text('represented_by')))
    return tuple(heads)


def read_interference_spheres(
    file: YamlMapping, version: int = 1, ground: str = 'scapula'
) -> tuple[InterferenceSphere, ...]:
    """Return the interference spheres of a file, in its unit of length."""
    spheres = []
    for name, entry in file.mappings('interference_spheres'):
        check_keys(entry, 'interference_spheres.NAME')
        if version == 1 and 'bone' in entry:
            raise entry.fault('bone', 'unknown key in version 1; version: 2 has it')
        bone = entry.content.get('bone', ground)
        with name_keys(entry):
            centre, radius = entry.point('centre'), entry.number('radius')
            spheres.append(InterferenceSphere(name, centre, radius, bone))
    return tuple(spheres)


def _read_landmarks(file: YamlMapping) -> tuple[Landmark, ...]:
    landmarks = []
    for name, entry in file.mappings('landmarks'):
        check_keys(entry, 'landmarks.NAME')
        with name_keys(entry):
            landmarks.append(Landmark(name, entry.content['bone'], entry.point('at')))
    return tuple(landmarks)


def _read_range_of_motion(file: YamlMapping) -> tuple[Interval, Interval, Interval] | None:
    if 'range_of_motion' not in file:
        return None
    limits = file.mapping('range_of_motion')
    check_keys(limits, 'range_of_motion')
    (a, b), (c, d), (e, f) = (limits.numbers(coordinate, 2) for coordinate in COORDINATES)
    return (a, b), (c, d), (e, f)


def bundled_models() -> dict[str, str]:
    """Return the texts of the model files that come with the package, by name."""
    folder = resources.files('linkedplane_ros') / 'models'
    return {
        entry.name.removesuffix('.yaml'): entry.read_text(encoding='utf-8')
        for entry in folder.iterdir()
        if entry.name.endswith('.yaml')
    }
