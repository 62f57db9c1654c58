# SPDX-License-Identifier: Apache-2.0
"""The JSON Schema of the model file: made of the reader's keys, it refuses what the reader does."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from optional import requires
from spoilt_models import REQUIRED, WRONG, Content, spoil
from varied_muscles import MUSCLES

from linkedplane_ros import BroadMuscle
from linkedplane_ros.muscle.file import bundled_models
from linkedplane_ros.muscle.keys import KEYS, TYPES, known_keys
from linkedplane_ros.muscle.schema import FILE, json_schema, schema_text
from linkedplane_ros.muscle.writing import file_content

pytestmark = requires('jsonschema')

DOCUMENT = (Path(__file__).parents[2] / 'doc' / 'reference' / 'model_format.md').read_text()

# What a schema cannot tell: counts, names and values that have to suit others; nan
BEYOND = (
    'of the bands of the head', 'no head has', 'is not a band', 'of 9 numbers expected',
    'for each band, expected, a list of 1', 'is a polynomial in s', 'finite',
    'a radius > 0 expected', 'zero', 'the lowest, then',
)  # fmt: skip
TOLD = [case for case in WRONG if not any(each in case[2] for each in BEYOND)]


def faults(model: Any) -> list[str]:
    from jsonschema import Draft7Validator

    return [error.message for error in Draft7Validator(json_schema()).iter_errors(model)]


def test_the_schema_is_one() -> None:
    from jsonschema import Draft7Validator

    Draft7Validator.check_schema(json_schema())


@pytest.mark.parametrize('name', bundled_models())
def test_every_bundled_model_is_valid_and_names_the_schema(name: str) -> None:
    text = bundled_models()[name]
    assert faults(yaml.safe_load(text)) == []
    first = text.splitlines()[0]
    assert first == '# yaml-language-server: $schema=broad_muscle.schema.json'
    assert (FILE.parent / first.partition('$schema=')[2]).is_file()


@pytest.mark.parametrize('case', MUSCLES)
def test_what_is_written_is_valid(case: str) -> None:
    assert faults(file_content(MUSCLES[case]().definition)) == []


@pytest.mark.parametrize('key', REQUIRED)
def test_a_missing_key_is_refused(key: str, content: Content) -> None:
    assert faults(spoil(content, key, ...))


@pytest.mark.parametrize(('key', 'value', 'reason'), TOLD)
def test_what_the_reader_refuses_is_refused(
    key: str, value: Any, reason: str, content: Content
) -> None:
    assert faults(spoil(content, key, value)), reason


@pytest.mark.parametrize('frame', ['ground', ['humerus'] * 9])
def test_points_of_a_moving_frame_are_refused_where_there_is_none(
    frame: Any, content: Content
) -> None:
    spoil(content, 'sphere.frame', frame)
    assert faults(content)
    for key in ('sphere.ground_point', 'sphere.humeral_point'):
        assert faults(content)
        spoil(content, key, ...)
    assert faults(content) == []
    mixed = ['humerus', 'moving'] * 4 + ['ground']
    assert faults(spoil(content, 'sphere.frame', mixed))  # a moving one needs them


def test_the_committed_schema_is_that_of_the_keys() -> None:
    assert FILE.read_text() == schema_text(), 'run: python -m linkedplane_ros.muscle.schema'


def test_every_key_has_a_type_and_a_meaning() -> None:
    assert len({key.path for key in KEYS}) == len(KEYS)
    for key in KEYS:
        assert not key.type or key.type in TYPES, key.path
        assert key.meaning.endswith('.'), key.path
        parent = key.path.rpartition('.')[0].removesuffix('.NAME')
        assert parent in {'', 'QUANTITY', 'POINTS', *(other.path for other in KEYS)}, key.path


@pytest.mark.parametrize('name', bundled_models())
def test_what_is_written_has_every_needed_key_and_no_unknown_one(name: str) -> None:
    written = file_content(BroadMuscle.load(name).definition)
    needed, others = known_keys('')
    assert set(needed) <= set(written) <= {*needed, *others}


def test_the_quantities_of_the_document_are_valid(content: Content) -> None:
    content['bands'] = {'names': ['a', 'b', 'c'], 's': [0.0, 0.5, 1.0]}
    del content['heads']
    blocks = [block.partition('```')[0] for block in DOCUMENT.split('```yaml\n')[1:]]
    for block in blocks:
        if not block.startswith('format: linkedplane_ros/subject'):
            content.update(yaml.safe_load(block) or {})
    assert 'list' in content['insertion']
    assert faults(content) == []
