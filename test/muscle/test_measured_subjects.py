# SPDX-License-Identifier: Apache-2.0
"""A subject measured: the scale that landmarks and distances give."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from linkedplane_ros import BroadMuscle, ModelError
from linkedplane_ros.muscle.parts import Landmark

DELTOID = BroadMuscle.load('deltoid')
FACTORS = np.array((1.1, 0.9, 1.3))
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


def landmark_in_cm(name: str) -> np.ndarray:
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
    spine = float(np.linalg.norm(landmark_in_cm('acromion') - landmark_in_cm('spinal_end')))
    arm = float(np.linalg.norm(landmark_in_cm('tuberosity')))
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
    arm = float(np.linalg.norm(landmark_in_cm('tuberosity')))
    measured = [{'from': 'joint_centre', 'to': 'tuberosity', 'length': 1.2 * arm}]
    found = DELTOID.scaled(subject(distances=measured))
    np.testing.assert_allclose(found.origins, 1.2 * DELTOID.origins, rtol=1e-12)


def test_the_factors_are_those_of_least_squares(subject: Write) -> None:
    names = ('acromion', 'clavicular_end', 'spinal_end', 'sternoclavicular_joint')
    mine = np.array([landmark_in_cm(name) for name in names])
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
        ({'distances': [{**TIP, 'length': 1e300}]}, 'distances: 1e[+]300 given, less than 10 m'),
        ({'points': {'acromion': [1e4, 0, 0]}}, 'points: 10000 given, less than 10 m expected'),
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
    with pytest.raises(ModelError, match='landmarks that lie in one place give no size'):
        centred.scaled(subject(points={'middle': [1.0, 0.0, 0.0]}))
