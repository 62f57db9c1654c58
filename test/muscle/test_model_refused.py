# SPDX-License-Identifier: Apache-2.0
"""One line for every way a model file can be wrong."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from spoilt_models import REQUIRED, WRONG, Content, Write, spoil

from linkedplane_ros import BroadMuscle, ModelError


def refusal(path: Path | str) -> str:
    """Return the message of the ModelError that loading a file ends in."""
    with pytest.raises(ModelError) as caught:
        BroadMuscle.load(path)
    message = str(caught.value)
    assert '\n' not in message
    assert caught.value.__cause__ is None
    return message


@pytest.mark.parametrize('key', REQUIRED)
def test_a_missing_key_is_named(key: str, content: Content, write: Write) -> None:
    path = write(spoil(content, key, ...))
    assert refusal(path) == f'{path}: {key}: missing'


@pytest.mark.parametrize(('key', 'value', 'reason'), WRONG)
def test_a_wrong_value_is_named_with_its_file_key_and_reason(
    key: str, value: Any, reason: str, content: Content, write: Write
) -> None:
    path = write(spoil(content, key, value))
    message = refusal(path)
    assert message.startswith(f'{path}: {key}')
    assert reason in message


@pytest.mark.parametrize('text', ['hello', 'one', 'e', '1e', '1 000'])
def test_only_a_number_is_told_how_yaml_writes_it(
    text: str, content: Content, write: Write
) -> None:
    message = refusal(write(spoil(content, 'sphere.radius', [text])))
    assert message.endswith(f'a number expected, {text!r} given')


@pytest.mark.parametrize('frame', ['ground', 'humerus', ['ground'] * 9])
def test_points_of_a_moving_frame_are_refused_where_there_is_none(
    frame: Any, content: Content, write: Write
) -> None:
    path = write(spoil(content, 'sphere.frame', frame))
    given = frame if isinstance(frame, str) else frame[0]
    reason = f'is for moving frames; given here: {given}'
    assert refusal(path) == f'{path}: sphere.ground_point: {reason}'


def test_a_number_that_is_not_finite_is_named_by_its_place(content: Content, write: Write) -> None:
    content['origin']['y'][2] = float('nan')
    path = write(content)
    assert refusal(path).startswith(f'{path}: origin.y[2]: a finite number expected')


def test_a_reference_normal_along_the_first_band_is_refused(content: Content, write: Write) -> None:
    muscle = BroadMuscle.load('deltoid')
    line = muscle.insertions[0] - muscle.origins[0]
    path = write(spoil(content, 'reference_normal', (line / np.linalg.norm(line)).tolist()))
    message = refusal(path)
    assert message.startswith(f'{path}: reference_normal: parallel to the first band')
    assert 'anterior_1' in message


def test_a_band_without_length_is_refused(content: Content, write: Write) -> None:
    path = write(spoil(content, 'insertion', content['origin']))
    assert refusal(path).startswith(f'{path}: insertion: band anterior_1 ends where it begins')


def test_a_ground_point_in_line_with_an_origin_is_refused(content: Content, write: Write) -> None:
    path = write(spoil(content, 'sphere.ground_point', content['sphere']['humeral_point']))
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
    assert 'format' in refusal(write(spoil(content, 'format', 'first\nsecond')))
