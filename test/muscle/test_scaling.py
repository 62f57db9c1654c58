"""A model at a subject's size: what scales how, and what a measurement makes of it."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
import yaml
from random_muscles import framed
from test_model_saved import every_variation

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, ModelError
from linkedplane_ros.commands.main import main
from linkedplane_ros.muscle.definition import Landmark, Listed, Polynomial
from linkedplane_ros.muscle.scaling import Scale

if TYPE_CHECKING:
    from ros_harness import Peer

    from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher

DELTOID = BroadMuscle.load('deltoid')
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
POSES = np.array(
    [
        THESIS.rotation(angles)
        for angles in np.random.default_rng(12).uniform([-0.7, 0.0, -1.0], [2.0, 2.0, 1.0], (60, 3))
    ]
)
FACTORS = np.array((1.1, 0.9, 1.3))


def variations() -> dict[str, BroadMuscle]:
    """Return a muscle with its spheres in each frame."""
    return {'deltoid': DELTOID, 'all': BroadMuscle.of(every_variation())} | {
        frame: framed(4, frame)[0] for frame in ('moving', 'ground', 'humerus', 'mixed')
    }


@pytest.mark.parametrize('factor', [0.3, 1.07, 2.0])
@pytest.mark.parametrize('name', variations())
def test_lengths_and_moment_arms_scale_with_the_muscle(name: str, factor: float) -> None:
    muscle = variations()[name]
    here, there = (LinkedPlaneSolver(m).solve_batch(POSES) for m in (muscle, muscle.scaled(factor)))
    np.testing.assert_array_equal(there.wrap, here.wrap)
    # m: rounding; lengths hang on theta by up to 0.1 m/rad
    np.testing.assert_allclose(there.lengths, factor * here.lengths, rtol=0.0, atol=1e-12)
    moments = factor * here.moment_vectors
    np.testing.assert_allclose(there.moment_vectors, moments, rtol=0.0, atol=1e-11)


def test_the_deltoids_moment_arms_scale_to_rounding() -> None:
    here, there = (LinkedPlaneSolver(m).solve_batch(POSES) for m in (DELTOID, DELTOID.scaled(1.1)))
    off = np.abs(there.moment_vectors - 1.1 * here.moment_vectors).max()
    assert off < 1e-12  # m


def test_an_even_scale_keeps_polynomials_units_and_the_plane_angles() -> None:
    scaled = DELTOID.scaled(1.1).definition
    assert scaled.length == 'mm'
    for key, curve in scaled.curves().items():
        assert isinstance(curve, Polynomial), key
    assert scaled.plane_angle == DELTOID.definition.plane_angle
    assert scaled.reference_normal == DELTOID.definition.reference_normal
    assert scaled.source == f'{DELTOID.source}; scaled by 1.1'


@pytest.mark.parametrize('scale', [1, 1.0, '1', (1.0, 1.0, 1.0), '1,1,1,1,1,1', Scale()])
def test_a_scale_of_one_changes_nothing(scale: Any) -> None:
    assert DELTOID.scaled(scale) == DELTOID


def test_points_scale_along_the_axes_of_their_bone() -> None:
    humerus = np.array((1.2, 1.0, 0.8))
    scaled = DELTOID.scaled((*FACTORS, *humerus))
    for field, factors in (
        ('origins', FACTORS),
        ('insertions', humerus),
        ('ground_point', FACTORS),
        ('humeral_point', humerus),
        ('interference_centres', FACTORS),
    ):
        want = getattr(DELTOID, field) * factors
        # m: the rounding of polynomials whose terms are a thousand times their sum
        np.testing.assert_allclose(getattr(scaled, field), want, rtol=0.0, atol=1e-14)
    factors_of = {'scapula': FACTORS, 'humerus': humerus}
    for mark, was in zip(scaled.landmarks, DELTOID.landmarks, strict=True):
        np.testing.assert_allclose(mark.at, was.at * factors_of[mark.bone], rtol=1e-14)
    assert scaled.range_of_motion == DELTOID.range_of_motion


@pytest.mark.parametrize('frame', ['ground', 'humerus'])
def test_a_sphere_on_a_bone_goes_along_and_stays_a_sphere(frame: str) -> None:
    muscle, _ = framed(4, frame)
    other = (1.0, 1.0, 1.0)
    scaled = muscle.scaled((*FACTORS, *other) if frame == 'ground' else (*other, *FACTORS))
    np.testing.assert_allclose(scaled.sphere_centres, muscle.sphere_centres * FACTORS, rtol=1e-14)
    mean = np.prod(FACTORS) ** (1.0 / 3.0)
    np.testing.assert_allclose(scaled.sphere_radii, muscle.sphere_radii * mean, rtol=1e-14)


def test_a_sphere_in_a_moving_frame_scales_by_the_mean_of_both_bones() -> None:
    scaled = DELTOID.scaled((*FACTORS, 1.2, 1.0, 0.8))
    mean = np.prod((*FACTORS, 1.2, 1.0, 0.8)) ** (1.0 / 6.0)
    np.testing.assert_allclose(scaled.sphere_centres, DELTOID.sphere_centres * mean, rtol=1e-14)
    np.testing.assert_allclose(scaled.sphere_radii, DELTOID.sphere_radii * mean, rtol=1e-14)
    assert isinstance(scaled.definition.sphere_radius, Polynomial)


def test_spheres_in_many_frames_each_scale_with_their_own() -> None:
    muscle = BroadMuscle.of(every_variation())
    scaled = muscle.scaled(tuple(FACTORS))
    mean = np.prod(FACTORS) ** (1.0 / 3.0)
    for i, frame in enumerate(muscle.sphere_frames):
        want = muscle.sphere_centres[i] * (mean if frame == 'moving' else FACTORS)
        np.testing.assert_allclose(scaled.sphere_centres[i], want, rtol=1e-14)
    assert all(isinstance(curve, Listed) for curve in scaled.definition.sphere_centre)


def test_the_reference_plane_is_the_same_plane_of_the_scaled_muscle() -> None:
    normal, scaled = DELTOID.reference_normal, DELTOID.scaled(tuple(FACTORS)).reference_normal
    for within in np.cross(normal, np.eye(3)):
        assert scaled @ (within * FACTORS) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize('scale', ['1.07', '1.1,0.9,1.3', '1.1,0.9,1.3,1.2,1,0.8'])
@pytest.mark.parametrize('name', variations())
def test_a_scaled_muscle_is_saved_and_loaded_to_the_bit(
    name: str, scale: str, tmp_path: Path
) -> None:
    muscle = variations()[name].scaled(scale)
    muscle.to_yaml(tmp_path / 'scaled.yaml')
    loaded = BroadMuscle.load(tmp_path / 'scaled.yaml')
    assert loaded == muscle
    assert loaded.origins.tobytes() == muscle.origins.tobytes()


# Measured

Write = Callable[..., Path]


@pytest.fixture
def subject(tmp_path: Path) -> Write:
    """Writer of a subject's file; keys may be replaced, or removed by None."""

    def write(**keys: Any) -> Path:
        content = {
            'format': 'linkedplane_ros/subject',
            'version': 1,
            'units': {'length': 'cm'},
            **keys,
        }
        path = tmp_path / 'subject.yaml'
        path.write_text(yaml.safe_dump({key: v for key, v in content.items() if v is not None}))
        return path

    return write


def place(name: str) -> np.ndarray:
    """Return a landmark of the deltoid in cm."""
    return 100.0 * np.array(next(each.at for each in DELTOID.landmarks if each.name == name))


def test_points_measured_on_a_scaled_model_give_its_factors(subject: Write) -> None:
    wanted = DELTOID.scaled((1.1, 0.9, 1.2, 1.05, 1.0, 1.25))
    points = {mark.name: (100.0 * np.array(mark.at)).tolist() for mark in wanted.landmarks}
    found = DELTOID.scaled(subject(points=points))
    np.testing.assert_allclose(found.origins, wanted.origins, rtol=1e-12)
    np.testing.assert_allclose(
        found.insertions[:, [0, 2]], wanted.insertions[:, [0, 2]], rtol=1e-12
    )
    # the tuberosity lies beside the joint: y is told by the mean of x and z
    mean = np.sqrt(1.05 * 1.25)
    np.testing.assert_allclose(found.insertions[:, 1], mean * DELTOID.insertions[:, 1], rtol=1e-12)
    assert 'has it (5 points, off by 0.0 mm rms)' in found.source


def test_distances_give_a_factor_for_each_bone(subject: Write) -> None:
    spine = float(np.linalg.norm(place('acromion') - place('spinal_end')))
    arm = float(np.linalg.norm(place('tuberosity')))
    measured = subject(
        distances=[
            {'from': 'acromion', 'to': 'spinal_end', 'length': 1.1 * spine},
            {'from': 'tuberosity', 'to': 'joint_centre', 'length': 0.9 * arm},
        ]
    )
    found = DELTOID.scaled(measured)
    np.testing.assert_allclose(found.origins, 1.1 * DELTOID.origins, rtol=1e-12)
    np.testing.assert_allclose(found.insertions, 0.9 * DELTOID.insertions, rtol=1e-12)
    assert 'has it (2 distances, off by 0.0 mm rms)' in found.source


def test_a_bone_that_was_not_measured_takes_the_others_factor(subject: Write) -> None:
    arm = float(np.linalg.norm(place('tuberosity')))
    measured = [{'from': 'joint_centre', 'to': 'tuberosity', 'length': 1.2 * arm}]
    found = DELTOID.scaled(subject(distances=measured))
    np.testing.assert_allclose(found.origins, 1.2 * DELTOID.origins, rtol=1e-12)


def test_the_factors_are_those_of_least_squares(subject: Write) -> None:
    names = ('acromion', 'clavicular_end', 'spinal_end', 'sternoclavicular_joint')
    mine = np.array([place(name) for name in names])
    theirs = mine * FACTORS + np.random.default_rng(3).normal(0.0, 0.3, mine.shape)
    found = DELTOID.scaled(subject(points=dict(zip(names, theirs.tolist(), strict=True))))
    best = (found.origins / DELTOID.origins)[0]
    off = np.square(theirs - mine * best).sum()
    for axis in np.eye(3):
        for step in (-1e-3, 1e-3):
            assert np.square(theirs - mine * (best + step * axis)).sum() > off
    rms = 10.0 * np.sqrt(off / 4.0)  # mm a landmark
    assert f'off by {rms:.1f} mm rms' in found.source


def test_the_examples_of_the_document_fit_the_deltoid(tmp_path: Path) -> None:
    document = (Path(__file__).parents[2] / 'doc' / 'reference' / 'model_format.md').read_text()
    blocks = [block.partition('```')[0] for block in document.split('```yaml\n')[1:]]
    subjects = [block for block in blocks if block.startswith('format: linkedplane_ros/subject')]
    assert len(subjects) == 2
    for text in subjects:
        path = tmp_path / 'subject.yaml'
        path.write_text(text)
        size = DELTOID.scaled(path).insertions[0] / DELTOID.insertions[0]
        assert (size > 1.0).all()
        assert (size < 1.15).all()


@pytest.mark.parametrize(
    ('scale', 'told'),
    [
        ('0', 'a factor > 0 expected'),
        (-1.0, 'a factor > 0 expected'),
        ('nan', 'a factor > 0 expected'),
        ('inf', 'a factor > 0 expected'),
        ('large', "'large' given; one factor, 3"),
        ('1,2', "'1,2' given; one factor, 3"),
        ((), 'one factor, 3'),
        ('', 'one factor, 3'),
        ('absent.yaml', 'absent.yaml: cannot be read: No such file'),
    ],
)
def test_what_is_no_scale_is_refused(scale: Any, told: str) -> None:
    with pytest.raises(ModelError, match=told):
        DELTOID.scaled(scale)


TIP = {'from': 'acromion', 'to': 'spinal_end', 'length': 13.0}


@pytest.mark.parametrize(
    ('keys', 'told'),
    [
        ({}, 'points: or distances expected, one of the two'),
        ({'points': {'acromion': [1, 2, 3]}, 'distances': [TIP]}, 'one of the two'),
        ({'points': {}}, 'points: none given; acromion, clavicular_end'),
        ({'points': {'elbow': [1, 2, 3]}}, 'points.elbow: unknown key; known here: acromion'),
        ({'points': {'acromion': [1, 2]}}, 'points.acromion: a list of 3 numbers expected'),
        ({'distances': []}, 'distances: a list of {from'),
        ({'distances': {'a': 1}}, 'distances: a list of {from'),
        ({'distances': [{'from': 'acromion', 'length': 3.0}]}, r'distances\[0\].to: missing'),
        ({'distances': [{**TIP, 'to': 'elbow'}]}, r"distances\[0\].to: 'elbow' given, one of acro"),
        ({'distances': [{**TIP, 'to': 'acromion'}]}, "'acromion' given; another landmark on the b"),
        ({'distances': [{**TIP, 'to': 'tuberosity'}]}, "'tuberosity' given; another landmark on t"),
        ({'distances': [{**TIP, 'length': 130.0}]}, "scapula: 10.3 times the model's size"),
        ({'distances': [{**TIP, 'length': -13.0}]}, "scapula: -1.03 times the model's size"),
        ({'points': {'acromion': [0, 0, 0]}}, "scapula: 0 times the model's size"),
        ({'units': None}, 'units: missing'),
        ({'units': {'length': 'inch'}}, 'm, cm, mm expected'),
        ({'version': 2}, 'version: 2 given, 1 expected'),
        ({'format': 'linkedplane_ros/broad_muscle'}, "'linkedplane_ros/subject' expected"),
        ({'weight': 80.0}, 'weight: unknown key'),
    ],
)
def test_a_subjects_file_that_is_no_good_is_told_in_one_line(
    keys: dict, told: str, subject: Write
) -> None:
    path = subject(**keys)
    with pytest.raises(ModelError, match=told) as caught:
        DELTOID.scaled(path)
    assert str(caught.value).startswith(f'{path}: ')
    assert '\n' not in str(caught.value)


def test_a_model_without_landmarks_cannot_be_measured_by(subject: Write) -> None:
    with pytest.raises(ModelError, match='the model deltoid has no landmarks to measure by'):
        replace(DELTOID, landmarks=()).scaled(subject(distances=[TIP]))
    centred = replace(DELTOID, landmarks=(Landmark('middle', 'scapula', (0.0, 0.0, 0.0)),))
    with pytest.raises(ModelError, match='landmarks that lie in one place tell nothing'):
        centred.scaled(subject(points={'middle': [1.0, 0.0, 0.0]}))


# On the command line


def test_the_commands_take_a_scale(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(['info', '--scale', '1.1']) == 0
    assert '; scaled by 1.1\n' in capsys.readouterr().out
    pose = ['--convention', THESIS.name, '0.3', '0.8', '-0.2']
    assert main(['solve', '--json', '--scale', '1.1,0.9,1.3', *pose]) == 0
    want = LinkedPlaneSolver(DELTOID.scaled((1.1, 0.9, 1.3))).solve(
        THESIS.rotation((0.3, 0.8, -0.2))
    )
    assert json.loads(capsys.readouterr().out)['lengths_m'] == want.lengths.tolist()
    table = tmp_path / 'motion.csv'
    table.write_text('time,flexion,abduction,rotation\n0.0,0.3,0.8,-0.2\n0.1,0.3,0.8,-0.2\n')
    out = tmp_path / 'out.csv'
    assert main(['process', str(table), str(out), '--scale', '1.1,0.9,1.3']) == 0
    text = out.read_text()
    assert '# scale: 1.1,0.9,1.3\n' in text
    assert repr(float(want.lengths[0])) in text
    assert main(['info', '--scale', 'two']) == 1
    captured = capsys.readouterr()
    assert captured.err.startswith("linkedplane: scale: 'two' given; one factor")


# On the node


@pytest.mark.parametrize(
    ('value', 'want'),
    [('1.1', 1.1), (1.1, 1.1), (2, 2.0), ([1.1, 0.9, 1.3], (1.1, 0.9, 1.3)), ('1', 1.0)],
)
def test_the_nodes_scale_is_text_or_numbers(value: Any, want: Any) -> None:
    from linkedplane_ros.node.parameters import SPECS
    from linkedplane_ros.node.settings import Settings

    values = {spec.name: spec.default for spec in SPECS} | {'scale': value}
    assert Settings.from_values(values).solvers[0].muscle == DELTOID.scaled(want)


@pytest.mark.parametrize('value', ['large', 0.0, -1, [1.0, 2.0], True, 'absent.yaml', ''])
def test_a_scale_that_is_none_is_refused(value: Any) -> None:
    from linkedplane_ros.node.parameters import SPECS
    from linkedplane_ros.node.settings import Settings

    values = {spec.name: spec.default for spec in SPECS} | {'scale': value}
    with pytest.raises(ValueError, match=r'scale|cannot be read'):
        Settings.from_values(values)


def test_a_running_node_takes_another_scale(node: MuscleStatePublisher, peer: Peer) -> None:
    from rclpy.parameter import Parameter

    pose = (0.3, 0.8, -0.2)
    for scale in ('1', 1.25, [1.1, 0.9, 1.3]):
        done = node.set_parameters([Parameter('scale', value=scale)])
        assert done[0].successful, done[0].reason
        for topic in peer.got.values():
            topic.clear()
        peer.send(THESIS.coordinates, pose)
        assert peer.answers(1)
        muscle = DELTOID.scaled(scale if isinstance(scale, list) else float(scale))
        state = LinkedPlaneSolver(muscle).solve(THESIS.rotation(pose))
        np.testing.assert_allclose(
            peer.got['band_lengths'][0].data, state.lengths, rtol=0.0, atol=1e-12
        )
    assert peer.until(lambda: bool(peer.diagnostics) and peer.values()['scale'] == '1.1,0.9,1.3')
    [refused] = node.set_parameters([Parameter('scale', value=-1.0)])
    assert not refused.successful
    assert refused.reason == 'scale: -1 given, a factor > 0 expected'
