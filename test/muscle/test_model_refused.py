# SPDX-License-Identifier: Apache-2.0
"""One line for every way a model file can be wrong."""

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from spoilt_models import REQUIRED, WRONG, Content, Write, spoil

from linkedplane_ros import BroadMuscle, ModelError
from linkedplane_ros.muscle.yaml_mapping import load_yaml


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


@pytest.mark.parametrize('text', ['1e-3', '-2.5E3', '5.e2', '.5e2', '1e5'])
def test_a_single_number_is_told_how_yaml_writes_it(
    text: str, content: Content, write: Write
) -> None:
    for key in ('sphere.radius', 'interference_spheres.sphere_4.radius', 'bands.s.first'):
        path = write(yaml.safe_dump(spoil(copy.deepcopy(content), key, text)))
        assert refusal(path).endswith(' given; write 1.0e-3, not 1e-3')


@pytest.mark.parametrize(
    'text', ['hello', 'one', 'e', '1e', '1 000', '...e3', '1.2.3e4', 'e5', '1e-', '٣e3']
)
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


NAMED = {  # what YAML makes of a name: text of it, and what the message calls that
    '1': '1',
    '1.5': '1.5',
    'true': 'True',
    'no': 'False',
    'null': 'nothing',
    '~': 'nothing',
    '2024-01-01': 'the date 2024-01-01',
    '.inf': 'inf',
}
SECTIONS = {
    'interference_spheres': '{centre: [1, 2, 3], radius: 4}',
    'landmarks': '{bone: scapula, at: [1, 2, 3]}',
    'heads': '{bands: [a], represented_by: a}',
}


@pytest.mark.parametrize('name', NAMED)
@pytest.mark.parametrize('section', SECTIONS)
def test_a_name_that_yaml_takes_for_something_else_is_refused(
    section: str, name: str, content: Content, write: Write
) -> None:
    content.pop(section, None)
    text = f'{yaml.safe_dump(content)}{section}:\n  {name}: {SECTIONS[section]}\n'
    path = write(text)
    hint = 'what YAML takes for a number, a date, true or nothing is text in quotes'
    given = f'names expected, {NAMED[name]} given; {hint}'
    assert refusal(path) == f'{path}: {section}: {given}'
    quoted = refusal_or_none(write(text.replace(f'  {name}:', f'  "{name}":')))
    assert quoted is None or 'is not a band' in quoted  # the head's


def refusal_or_none(path: Path) -> str | None:
    try:
        BroadMuscle.load(path)
    except ModelError as error:
        return str(error)
    return None


def bomb(levels: int, inner: str = '[{}]') -> str:
    """Return a YAML text of nine to the power of so many values."""
    lines = ['a0: &a0 [x]' if inner == '[{}]' else 'a0: &a0 {k: 1}']
    for i in range(1, levels):
        lines.append(f'a{i}: &a{i} ' + inner.format(', '.join([f'*a{i - 1}'] * 9)))
    return '\n'.join(lines) + '\n'


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        (bomb(30), 'more than 10000 values by aliases (*)'),
        (bomb(30, '{{<<: [{}]}}'), 'more than 10000 values by aliases (*)'),
        ('a: &a [*a]', 'more than 10000 values by aliases (*)'),
        ('&a {a: *a}', 'more than 10000 values by aliases (*)'),
        ('a: [' + '1,' * 300_000 + ']', 'more than 10000 values'),
        ('a: [' + '1,' * 10_000 + ']', 'more than 10000 values'),
        ('[' * 100_000, 'nested too deeply'),
        ('[' * 21 + ']' * 21, 'nested too deeply'),
        ('a: ' + '{a: ' * 21 + '1' + '}' * 21, 'nested too deeply'),
        ('a: ' + '1:' * 300_000 + '1', 'at line 1: a number of 600001 characters'),
        *(
            (
                f'a: [{text}]',
                f"at line 1: '{text}' is a number in YAML 1.1 that 1.2 reads otherwise",
            )
            for text in ('010', '-017', '1:30', '1:30.5', '1_000', '1_0.5', '0b11')
        ),
        ('a: ' + '7' * 900_000, 'at line 1: a number of 900000 characters'),
        ('a: "\\ud800"', "at line 1: '\\ud800' is not Unicode"),
        ('a: !!bool maybe', 'a value cannot be read'),
        ('a: !!int ""', 'a value cannot be read'),
        ('a: !!timestamp now', 'a value cannot be read'),
        ('a: 2024-13-45', "at line 1: a value cannot be read: '2024-13-45' is no timestamp"),
        ('\na: !!float ""', "at line 2: a value cannot be read: '' is no float"),
        ('a: !!timestamp "x"', "at line 1: a value cannot be read: 'x' is no timestamp"),
    ],
)
def test_yaml_that_is_a_trap_is_refused_in_a_short_line(
    text: str, reason: str, write: Write
) -> None:
    path = write(text)
    message = refusal(path)
    assert message.startswith(f'{path}: not valid YAML')
    assert reason in message
    assert len(message) < len(str(path)) + 190


@pytest.mark.parametrize('text', ['10', '-10', '0', '+7', '0x1F', '010.5', '1.0e-3', '"1:30"'])
def test_what_every_yaml_reads_alike_is_read(text: str) -> None:
    assert load_yaml(text) == yaml.safe_load(text)


def test_a_list_may_be_used_twice_by_an_alias(content: Content, write: Write) -> None:
    names = content['bands']['names']
    content['heads'] = {'all': {'bands': names, 'represented_by': names[0]}}
    path = write(content)
    assert '*id' in path.read_text()
    assert BroadMuscle.load(path).heads[0].bands == tuple(names)


LONG = ('format', 'version', 'name', 'units.length', 'sphere.radius', 'sphere.frame',
        'heads.middle.represented_by', 'x' * 50_000)  # fmt: skip


@pytest.mark.parametrize('key', LONG, ids=lambda key: key[:30])
def test_a_long_value_is_cut_in_the_message(key: str, content: Content, write: Write) -> None:
    path = write(spoil(content, key, 'long ' * 20_000))
    assert len(refusal(path)) < len(str(path)) + 600


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
    assert 'bundled model (deltoid, deltoid_ackland2008, deltoid_girdle, ' in message


@pytest.mark.parametrize('key', ['first\nsecond', 3, None])
def test_an_odd_key_is_refused_on_one_line(key: Any, content: Content, write: Write) -> None:
    content[key] = 1
    assert 'unknown key' in refusal(write(content))


def test_an_odd_value_is_refused_on_one_line(content: Content, write: Write) -> None:
    assert 'format' in refusal(write(spoil(content, 'format', 'first\nsecond')))
