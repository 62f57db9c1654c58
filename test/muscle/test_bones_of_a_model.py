# SPDX-License-Identifier: Apache-2.0
"""The bones of a model: version 2 of its file, and what knows only the bones of a ball joint."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from optional import is_installed
from spoilt_models import Content, Write, spoil

from linkedplane_ros import BroadMuscle, Landmark, LinkedPlaneSolver, ModelError
from linkedplane_ros.fit.states import sphere_array
from linkedplane_ros.muscle.bones import BALL_JOINT, Bones
from linkedplane_ros.muscle.file import bundled_models
from linkedplane_ros.muscle.schema import json_schema
from linkedplane_ros.rivals.methods import methods
from linkedplane_ros.solver.report import model_report
from linkedplane_ros.study.subject import Subject

DELTOID, GIRDLE = (BroadMuscle.load(name) for name in ('deltoid', 'deltoid_girdle'))
TWISTED = replace(DELTOID, bones=Bones(origin=('humerus', *['scapula'] * 8)))
"""Its first band arises from the humerus."""


@pytest.fixture
def girdle() -> Content:
    """The content of the girdle's file."""
    return dict(yaml.safe_load(bundled_models()['deltoid_girdle']))


def faults(content: Content) -> list[str]:
    """Return what the JSON Schema has against a file."""
    if not is_installed('jsonschema'):
        pytest.skip('jsonschema is not installed')
    from jsonschema import Draft7Validator

    return [error.message for error in Draft7Validator(json_schema()).iter_errors(content)]


def test_the_girdle_is_the_deltoid_but_for_its_bones() -> None:
    # the numbers are the published ones; only what belongs to which bone is ours
    one, other = DELTOID.definition, GIRDLE.definition
    same = replace(other, name=one.name, source=one.source, bones=one.bones, landmarks=())
    assert same == replace(one, landmarks=())
    s = GIRDLE.definition.s_of_bands
    arise = np.array(GIRDLE.bones.of_bands('origin', 9))
    np.testing.assert_array_equal(arise == 'clavicle', s < 0.25)
    assert (GIRDLE.bones.ground_point, GIRDLE.bones.reference_normal) == ('clavicle', 'scapula')
    assert set(GIRDLE.bones.of_bands('insertion', 9)) == {GIRDLE.bones.humeral_point} == {'humerus'}
    assert GIRDLE.bones_of_interference == ('scapula',) * 3


@pytest.mark.parametrize('name', bundled_models())
def test_a_model_is_saved_in_the_version_that_it_has(name: str, tmp_path: Path) -> None:
    stated = yaml.safe_load(bundled_models()[name])
    BroadMuscle.load(name).to_yaml(tmp_path / 'saved.yaml')
    saved = yaml.safe_load((tmp_path / 'saved.yaml').read_text())
    assert saved['version'] == stated['version'] == (2 if name == 'deltoid_girdle' else 1)
    assert ('bones' in saved) == (stated['version'] == 2)


def test_a_muscle_over_bones_is_saved_to_the_bit(tmp_path: Path) -> None:
    varied = replace(
        GIRDLE,
        bones=Bones(
            ('thorax', 'scapula', 'humerus'),
            origin=['thorax', 'scapula', 'humerus'] * 3,
            insertion=['humerus', 'humerus', 'scapula'] * 3,
            reference_normal='scapula',
        ),
        sphere_frame=['ground', 'scapula', 'humerus'] * 3,
        interference_bones=('thorax', 'scapula', 'humerus'),
        landmarks=(Landmark('notch', 'thorax', (0.0, 0.1, 0.2)),),
    )
    varied.to_yaml(tmp_path / 'saved.yaml')
    again = BroadMuscle.load(tmp_path / 'saved.yaml')
    assert again == varied
    assert hash(again) == hash(varied)
    assert again.bones == varied.bones
    pose = {'scapula': (np.eye(3), [0.01, 0.0, 0.0])}
    one, other = (LinkedPlaneSolver(each).solve_bones(pose) for each in (again, varied))
    assert one.lengths.tobytes() == other.lengths.tobytes()
    content = yaml.safe_load((tmp_path / 'saved.yaml').read_text())
    assert faults(content) == []


def test_what_version_2_leaves_out_is_as_in_version_1(write: Write, content: Content) -> None:
    content.update(version=2, bones={'names': ['scapula', 'humerus']})
    muscle = BroadMuscle.load(write(content))
    assert muscle == DELTOID
    assert muscle.bones == BALL_JOINT
    assert faults(content) == []


WRONG: list[tuple[str, Any, str, bool]] = [
    # the key, what stands there (... for nothing), what is said, whether the schema knows
    ('bones', ..., 'bones: missing', True),
    ('bones.names', ..., 'bones.names: missing', True),
    ('bones.names', ['scapula'], 'the ground bone, then those that move expected', True),
    ('bones.names', [], 'the ground bone, then those that move expected', True),
    ('bones.names', ['scapula', 'humerus', 'humerus'], "'humerus' appears twice", True),
    ('bones.names', ['scapula', 'moving', 'humerus'], "'moving' given; a bone's name", True),
    ('bones.names', ['a b', 'humerus'], "'a b' given; a letter, then letters, digits", True),
    ('bones.names', 'scapula', 'a list of names expected, text given', True),
    ('bones.origin', 'thorax', "'thorax' given, one of scapula, clavicle, humerus expected", False),
    ('bones.origin', ['clavicle'] * 8, 'a list of 9 bones, one for each band, expected', False),
    ('bones.origin', ['clavicle'] * 8 + ['rib'], "bones.origin[8]: 'rib' given, one of", False),
    ('bones.insertion', 5, 'bones.insertion: 5 given, one of scapula', True),
    ('bones.insertion', '', "bones.insertion: '' given", True),
    ('bones.ground_point', ['clavicle'], "bones.ground_point: ['clavicle'] given, one of", True),
    ('bones.humeral_point', 'ulna', "bones.humeral_point: 'ulna' given, one of scapula", False),
    ('bones.reference_normal', None, 'bones.reference_normal: None given, one of', True),
    ('bones.plane_angle', 'humerus', 'bones.plane_angle: unknown key', True),
    ('bones', ['scapula', 'humerus'], 'a mapping of keys expected, a list given', True),
    ('sphere.frame', 'scapula', 'one of moving, ground, clavicle, humerus expected', True),
    ('sphere.frame', ['moving'] * 8 + ['rib'], "sphere.frame[8]: 'rib' given", False),
    ('interference_spheres.sphere_4.bone', 'rib', "bone: 'rib' given, one of scapula", False),
    ('landmarks.acromion.bone', 'rib', "acromion.bone: 'rib' given, one of scapula", False),
    ('version', 1, 'bones: unknown key in version 1; version: 2 has it', True),
]


@pytest.mark.parametrize(('key', 'value', 'reason', 'known'), WRONG)
def test_wrong_bones_are_named_with_their_file_key_and_reason(
    key: str, value: Any, reason: str, known: bool, girdle: Content, write: Write
) -> None:
    path = write(spoil(girdle, key, value))
    with pytest.raises(ModelError) as caught:
        BroadMuscle.load(path)
    message = str(caught.value)
    assert message.startswith(f'{path}: ')
    assert reason in message
    assert message.isprintable()
    assert bool(faults(girdle)) == known


@pytest.mark.parametrize(
    ('change', 'reason'),
    [
        ({'bones': ('scapula', 'humerus')}, "bones: ('scapula', 'humerus') given, Bones expected"),
        ({'interference_bones': ('humerus',)}, 'interference_bones: 1 given, 3 expected'),
        ({'interference_bones': ('rib',) * 3}, "interference_bones[0]: 'rib' given, one of"),
        ({'bones': Bones(origin=('scapula',) * 3)}, 'a list of 9 bones, one for each band, expect'),
        ({'bones': Bones(('pelvis', 'femur'))}, 'landmarks.acromion.bone: '),
    ],
)
def test_wrong_bones_are_refused_in_python(change: dict[str, Any], reason: str) -> None:
    with pytest.raises(ModelError) as caught:
        replace(DELTOID, **change)
    assert reason in str(caught.value)


def test_what_knows_only_a_ball_joint_takes_a_girdle_at_rest_and_refuses_others() -> None:
    for what in (sphere_array, methods):
        what(GIRDLE)
        for muscle in (TWISTED, replace(GIRDLE, interference_bones=('humerus',) * 3)):
            with pytest.raises(ModelError, match='takes a muscle of one ball joint, which has all'):
                what(muscle)


def test_a_study_refuses_a_muscle_of_another_joint(tmp_path: Path) -> None:
    TWISTED.to_yaml(tmp_path / 'twisted.yaml')
    with pytest.raises(ModelError, match='deltoid: a study takes a muscle of one ball joint'):
        Subject.load(str(tmp_path / 'twisted.yaml'))
    assert Subject.load('deltoid_girdle').muscle == GIRDLE


def test_the_girdle_scales_by_the_same_factors_for_all_bones(tmp_path: Path) -> None:
    for scale in (1.1, (1.1, 1.0, 0.9)):
        wide, plain = GIRDLE.scaled(scale), DELTOID.scaled(scale)
        assert wide.bones == GIRDLE.bones
        for field in ('origins', 'insertions', 'sphere_centres', 'ground_point'):
            assert getattr(wide, field).tobytes() == getattr(plain, field).tobytes(), field
    with pytest.raises(ModelError, match='on scapula, clavicle, humerus; one factor, or 3'):
        GIRDLE.scaled((1.1, 1.0, 0.9, 1.0, 1.0, 1.0))
    subject = tmp_path / 'subject.yaml'
    subject.write_text(
        'format: linkedplane_ros/subject\nversion: 1\nunits: {length: mm}\n'
        'points: {acromion: [10.9, -13.0, 35.2]}\n'
    )
    with pytest.raises(ModelError, match='measurements are for models of scapula and humerus'):
        GIRDLE.scaled(subject)


def test_a_report_says_which_bands_are_on_which_bone() -> None:
    lines = list(model_report(GIRDLE))
    assert 'arise from the clavicle: anterior_1, anterior_2' in lines
    assert 'arise from the scapula: ' + ', '.join(GIRDLE.band_names[2:]) in lines
    assert not any('end on' in line for line in lines)  # all on the humerus
    assert any('insertion (humerus)' in line for line in lines)
    assert not any('arise from' in line for line in model_report(DELTOID))
    assert list(model_report(TWISTED))
