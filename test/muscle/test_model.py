"""The model file: the published deltoid, and one line for every way a file can be wrong."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from reference import Array

import linkedplane_ros
from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, ModelError

BUNDLED = Path(linkedplane_ros.__file__).parent / 'models' / 'deltoid.yaml'
PRINTED = 1e-6  # mm: the last printed digit, rounded

# Table 6.2.1, mm. Erratum 2: at s = 0.662 the table prints 39.002657 and -24.278081.
ORIGINS = [
    (-30.364671, 29.960188, 50.400338),
    (-10.635975, 19.135245, 46.662769),
    (5.177352, 4.035993, 39.755528),
    (10.080286, -15.407628, 33.140352),
    (2.689311, -32.151317, 28.428708),
    (-14.557902, -40.244315, 25.776385),
    (-37.192806, -39.002657, 24.278081),
    (-60.506285, -33.147806, 22.361996),
    (-81.338976, -28.910651, 18.184419),
]
# Table 6.2.2, mm. Erratum 3: the z column is shifted at s = 0.569 (prints -96.184484) and 0.662
# (prints -96.717775).
INSERTIONS = [
    (27.612714, 18.917582, -98.235863),
    (29.151882, 14.704815, -98.006792),
    (30.461534, 10.438491, -97.535801),
    (31.511408, 6.133919, -96.970483),
    (32.271238, 1.80640, -96.458430),
    (32.710763, -2.528731, -96.147233),
    (32.799717, -6.856190, -96.184484),
    (32.507837, -11.160659, -96.717775),
    (31.804860, -15.426829, -97.894699),
]

Content = dict[str, Any]
Write = Callable[[Any], Path]


@pytest.fixture
def content() -> Content:
    """The bundled model file, to be spoilt."""
    loaded: Content = yaml.safe_load(BUNDLED.read_text(encoding='utf-8'))
    return loaded


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writer of a model file: of a text as it stands, of anything else as YAML."""

    def write_it(model: Any) -> Path:
        path = tmp_path / 'muscle.yaml'
        text = model if isinstance(model, str) else yaml.safe_dump(model, allow_unicode=True)
        path.write_text(text, encoding='utf-8')
        return path

    return write_it


def spoilt(content: Content, key: str, value: Any) -> Content:
    """Put a value (... removes it) under a dotted key."""
    *sections, last = key.split('.')
    here = content
    for section in sections:
        here = here[section]
    if value is ...:
        del here[last]
    else:
        here[last] = value
    return content


def refusal(path: Path | str) -> str:
    """Return the message of the ModelError that loading a file ends in."""
    with pytest.raises(ModelError) as caught:
        BroadMuscle.load(path)
    message = str(caught.value)
    assert '\n' not in message
    assert caught.value.__cause__ is None
    return message


def largest_gap(found_m: Array, printed_mm: Any) -> float:
    return float(np.abs(found_m * 1e3 - np.array(printed_mm)).max())


def test_the_deltoids_origins_are_those_of_table_6_2_1() -> None:
    # mm; the table was made with unrounded coefficients
    assert largest_gap(BroadMuscle.load('deltoid').origins, ORIGINS) < 1e-4


def test_the_deltoids_insertions_are_those_of_table_6_2_2() -> None:
    assert largest_gap(BroadMuscle.load('deltoid').insertions, INSERTIONS) < 1e-4


def test_the_deltoid_is_in_metres_and_its_normal_a_unit_vector() -> None:
    muscle = BroadMuscle.load('deltoid')
    np.testing.assert_allclose(muscle.ground_point, [-0.0955, 0.1354, 0.034], atol=1e-15)
    np.testing.assert_allclose(muscle.humeral_point, [0.0, 0.0, -0.02963], atol=1e-15)
    normal = np.array([-0.83, 0.29, -0.47])
    np.testing.assert_allclose(muscle.reference_normal, normal / np.linalg.norm(normal), atol=1e-15)
    # radius and phi over s = 0.10 .. 0.85: 36 to 14 mm and 0.48 to 0.16 rad, highest power first
    s = np.linspace(0.10, 0.85, 9)
    radius = [-14.833320, -16.211523, 2.679743, -9.323871, 37.294653]
    phi = [-0.471239, -0.515373, -0.366520, 0.072008, 0.444474]
    for found, coefficients, unit in (
        (muscle.sphere_radii, radius, 1e-3),
        (muscle.plane_angles, phi, 1.0),
    ):
        expected = sum(c * s ** (4 - k) for k, c in enumerate(coefficients))
        np.testing.assert_allclose(found, expected * unit, atol=1e-12)


def test_the_deltoids_heads_are_those_the_thesis_compares() -> None:
    muscle = BroadMuscle.load('deltoid')
    represented = {head.name: head.represented_by for head in muscle.heads}
    order = [muscle.band_names.index(represented[name]) for name in ('anterior', 'middle')]
    assert order == [1, 3]
    assert muscle.band_names.index(represented['posterior']) == 7
    assert muscle.head_of('posterior_3') == 'posterior'


def test_the_deltoids_interference_spheres_are_those_of_table_5_1() -> None:
    muscle = BroadMuscle.load('deltoid')
    centres = [(-0.20, 3.00, -1.00), (-13.50, -12.00, 20.40), (-35.70, 3.00, -10.00)]
    assert largest_gap(muscle.interference_centres, centres) < PRINTED
    assert largest_gap(muscle.interference_radii, [27.40, 24.30, 23.90]) < PRINTED


def test_a_file_gives_the_same_muscle_as_the_bundled_one(content: Content, write: Write) -> None:
    mine, bundled = BroadMuscle.load(write(content)), BroadMuscle.load('deltoid')
    assert mine.origins.tobytes() == bundled.origins.tobytes()
    assert BroadMuscle.load(str(write(content))).band_names == bundled.band_names


def test_units_of_a_file_are_converted(content: Content, write: Write) -> None:
    content['units'] = {'length': 'm', 'angle': 'deg'}
    muscle, bundled = BroadMuscle.load(write(content)), BroadMuscle.load('deltoid')
    np.testing.assert_allclose(muscle.origins, bundled.origins * 1e3, rtol=1e-14)
    np.testing.assert_allclose(muscle.sphere_radii, bundled.sphere_radii * 1e3, rtol=1e-14)
    np.testing.assert_allclose(muscle.plane_angles, np.radians(bundled.plane_angles), rtol=1e-14)


def test_a_file_without_interference_spheres_has_none(content: Content, write: Write) -> None:
    muscle = BroadMuscle.load(write(spoilt(content, 'interference_spheres', ...)))
    assert muscle.interference_centres.shape == (0, 3)
    assert muscle.interference_names == ()


@pytest.mark.parametrize('count', [1, 2, 40])
def test_a_file_may_name_any_number_of_bands(count: int, content: Content, write: Write) -> None:
    names = [f'band_{i}' for i in range(count)]
    content['bands']['names'] = names
    content['heads'] = {'all': {'bands': names, 'represented_by': names[0]}}
    muscle = BroadMuscle.load(write(content))
    assert muscle.origins.shape == (count, 3)
    assert LinkedPlaneSolver(muscle).solve(np.eye(3)).lengths.shape == (count,)


REQUIRED = (
    'format', 'version', 'name', 'source', 'units', 'units.length', 'units.angle', 'bands',
    'bands.s.first', 'bands.s.last', 'bands.names', 'heads.middle.bands',
    'heads.middle.represented_by', 'origin', 'origin.x', 'insertion', 'insertion.z', 'sphere',
    'sphere.frame', 'sphere.centre', 'sphere.centre.y', 'sphere.radius', 'sphere.ground_point',
    'sphere.humeral_point', 'plane_angle', 'reference_normal',
    'interference_spheres.sphere_4.centre', 'interference_spheres.sphere_4.radius',
)  # fmt: skip


@pytest.mark.parametrize('key', REQUIRED)
def test_a_missing_key_is_named(key: str, content: Content, write: Write) -> None:
    path = write(spoilt(content, key, ...))
    assert refusal(path) == f'{path}: {key}: missing'


# the spoilt key, what stands there, what the message says of it
WRONG: list[tuple[str, Any, str]] = [
    ('bone', 1, 'unknown key'),
    ('sphere.radii', [1.0], 'unknown key'),
    ('interference_spheres.sphere_4.colour', 'red', 'unknown key'),
    ('format', 'urdf', 'linkedplane_ros/broad_muscle'),
    ('version', 2, '1 expected'),
    ('version', '1', '1 expected'),
    ('version', True, '1 expected'),
    ('version', None, '1 expected'),
    ('name', 3, 'text expected'),
    ('name', '', 'text expected'),
    ('source', None, 'text expected'),
    ('units.length', 'inch', 'm, cm, mm expected'),
    ('units.angle', 'turns', 'rad, deg expected'),
    ('units.length', 3, 'm, cm, mm expected'),
    ('units.length', None, 'm, cm, mm expected'),
    ('units.length', ['mm'], 'm, cm, mm expected'),
    ('units', 'mm', 'mapping'),
    ('bands.s.first', 'a', 'a number expected'),
    ('bands.s.first', True, 'a number expected'),
    ('bands.names', [], 'a list of names expected'),
    ('bands.names', 'all', 'a list of names expected'),
    ('bands.names', ['one', 2], 'a list of names expected'),
    ('bands.names', ['one', 'one'], 'twice'),
    ('heads.middle.represented_by', 'anterior_1', 'not one of the bands of the head'),
    ('heads.middle.bands', ['middle_1', 'nobody'], "'nobody' is no band"),
    ('heads.middle.bands', ['middle_1', 'anterior_1'], "'anterior_1' is no band, or one of an"),
    ('heads', {}, "no head has the band 'anterior_1'"),
    ('heads', None, 'mapping'),
    ('heads.middle', [1], 'mapping'),
    ('origin', [1.0, 2.0, 3.0], 'mapping'),
    ('origin.x', [], 'a list of numbers expected'),
    ('origin.x', 'long', 'a number, a list of numbers'),
    ('origin.x', None, 'a number, a list of numbers'),
    ('origin.x', True, 'a number expected'),
    ('origin.x', [[1.0]], 'a number expected'),
    ('origin.x', {'list': [1.0, 2.0]}, 'a list of 9 numbers expected, a list of 2 given'),
    ('origin.x', {'lists': [1.0, 2.0]}, 'missing'),
    ('origin.x', {'list': [1.0] * 9, 'of': 'x'}, 'unknown key'),
    ('origin', {'list': [[1.0, 2.0, 3.0]]}, '9 points, one for each band, expected, a list of 1'),
    ('origin', {'list': 3.0}, '9 points, one for each band, expected, 3.0 given'),
    ('origin', {'list': [[1.0, 2.0]] * 9}, '3 numbers expected, a list of 2 given'),
    ('origin', {'list': [[1.0, 2.0, 3.0]] * 9, 'x': 1.0}, 'unknown key'),
    ('sphere.frame', 'sky', 'one of moving, ground, humerus expected'),
    ('sphere.frame', None, 'one of moving, ground, humerus expected'),
    ('sphere.frame', ['ground'], '9 frames, one for each band, expected, 1 given'),
    ('sphere.frame', ['ground'] * 8 + ['sky'], "'sky' given, one of moving, ground, humerus"),
    ('bands.s', [0.1, 0.2], 'a list of 9 numbers expected, a list of 2 given'),
    ('bands.s', ..., 'missing; origin.x is a polynomial in s'),
    ('bands.s', 3.0, 'mapping'),
    ('licence', '', 'text expected'),
    ('landmarks', [1.0], 'mapping'),
    ('landmarks', {'acromion': {'bone': 'scapula'}}, 'missing'),
    ('landmarks', {'acromion': {'bone': 'wing', 'at': [1, 2, 3]}}, 'one of scapula, humerus'),
    ('landmarks', {'acromion': {'bone': 'scapula', 'at': [1, 2]}}, '3 numbers expected'),
    ('landmarks', {'joint_centre': {'bone': 'scapula', 'at': [1, 2, 3]}}, 'is the origin of both'),
    ('range_of_motion.flexion', [1.0, 0.5], 'the lowest, then the highest'),
    ('sphere.radius', [float('nan')], 'finite'),
    ('sphere.radius', [float('inf')], 'finite'),
    ('sphere.radius', ['1e-3'], 'write 1.0e-3'),
    ('sphere.radius', [10**400], 'a finite number expected'),
    ('sphere.radius', [-1.0], 'a radius > 0 expected'),
    ('sphere.radius', [1.0, -0.5], 'a radius > 0 expected'),
    ('sphere.radius', [0.0], 'a radius > 0 expected'),
    ('sphere.ground_point', [1.0, 2.0], '3 numbers expected'),
    ('sphere.humeral_point', [1.0, 2.0, 3.0, 4.0], '3 numbers expected'),
    ('reference_normal', [0.0, 0.0, 0.0], 'zero'),
    ('reference_normal', [1.0, 0.0], '3 numbers expected'),
    ('reference_normal', 'up', '3 numbers expected'),
    ('interference_spheres.sphere_4.radius', -27.4, '> 0 expected'),
    ('interference_spheres.sphere_4.centre', [1.0], '3 numbers expected'),
    ('interference_spheres', [1.0], 'mapping'),
]


@pytest.mark.parametrize(('key', 'value', 'reason'), WRONG)
def test_a_wrong_value_is_named_with_its_file_key_and_reason(
    key: str, value: Any, reason: str, content: Content, write: Write
) -> None:
    path = write(spoilt(content, key, value))
    message = refusal(path)
    assert message.startswith(f'{path}: {key}')
    assert reason in message


@pytest.mark.parametrize('frame', ['ground', 'humerus', ['ground'] * 9])
def test_points_of_a_moving_frame_are_refused_where_there_is_none(
    frame: Any, content: Content, write: Write
) -> None:
    path = write(spoilt(content, 'sphere.frame', frame))
    told = f'is for moving frames; the frame here is {frame}'
    assert refusal(path) == f'{path}: sphere.ground_point: {told}'


def test_a_number_that_is_not_finite_is_named_by_its_place(content: Content, write: Write) -> None:
    content['origin']['y'][2] = float('nan')
    path = write(content)
    assert refusal(path).startswith(f'{path}: origin.y[2]: a finite number expected')


def test_a_reference_normal_along_the_first_band_is_refused(content: Content, write: Write) -> None:
    muscle = BroadMuscle.load('deltoid')
    line = muscle.insertions[0] - muscle.origins[0]
    path = write(spoilt(content, 'reference_normal', (line / np.linalg.norm(line)).tolist()))
    message = refusal(path)
    assert message.startswith(f'{path}: reference_normal: parallel to the first band')
    assert 'anterior_1' in message


def test_a_band_without_length_is_refused(content: Content, write: Write) -> None:
    path = write(spoilt(content, 'insertion', content['origin']))
    assert refusal(path).startswith(f'{path}: insertion: band anterior_1 ends where it begins')


def test_a_ground_point_in_line_with_an_origin_is_refused(content: Content, write: Write) -> None:
    path = write(spoilt(content, 'sphere.ground_point', content['sphere']['humeral_point']))
    assert refusal(path).startswith(f'{path}: sphere.ground_point: ')


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('a: [1, 2', 'not valid YAML at line'),
        ('a: b: c\n', 'not valid YAML at line 1'),
        ('\ta: 1\n', 'not valid YAML'),
        ('a: \x07\n', 'not valid YAML'),
        ('a: !!python/object:os.system {}\n', 'not valid YAML'),
        ('- 1\n- 2\n', 'a mapping of keys expected, a list given'),
        ('deltoid', 'a mapping of keys expected, text given'),
        ('', 'a mapping of keys expected, nothing given'),
    ],
)
def test_a_text_that_is_no_model_is_refused(text: str, reason: str, write: Write) -> None:
    path = write(text)
    message = refusal(path)
    assert message.startswith(f'{path}: ')
    assert reason in message


def test_an_absent_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / 'absent.yaml'
    assert refusal(path) == f'{path}: cannot be read: No such file or directory'


def test_a_folder_is_no_model(tmp_path: Path) -> None:
    path = tmp_path / 'folder.yaml'
    path.mkdir()
    assert refusal(path) == f'{path}: cannot be read: Is a directory'


def test_a_binary_file_is_no_model(tmp_path: Path) -> None:
    path = tmp_path / 'picture.yaml'
    path.write_bytes(bytes(range(256)))
    assert refusal(path) == f'{path}: cannot be read: not UTF-8 text'


@pytest.mark.parametrize('name', ['biceps', 'deltoid.urdf', '', '.', 'models/deltoid'])
def test_a_name_that_is_neither_bundled_nor_a_yaml_file_is_told_what_is(name: str) -> None:
    message = refusal(name)
    assert repr(name) in message
    assert 'bundled model (deltoid, deltoid_ackland2008, example_humerus_spheres, ' in message


@pytest.mark.parametrize('key', ['first\nsecond', 3, None])
def test_an_odd_key_is_refused_on_one_line(key: Any, content: Content, write: Write) -> None:
    content[key] = 1
    assert 'unknown key' in refusal(write(content))


def test_an_odd_value_is_refused_on_one_line(content: Content, write: Write) -> None:
    assert 'format' in refusal(write(spoilt(content, 'format', 'first\nsecond')))
