"""The JSON Schema of the model file: it, the reader and the document say the same."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml
from spoilt_models import REQUIRED, WRONG, Content, spoil
from varied_muscles import MUSCLES

import linkedplane_ros
from linkedplane_ros.muscle.broad_muscle import bundled_models
from linkedplane_ros.muscle.file import KEYS
from linkedplane_ros.muscle.writing import content as stated

jsonschema = pytest.importorskip('jsonschema')

MODELS = Path(linkedplane_ros.__file__).parent / 'models'
SCHEMA = json.loads((MODELS / 'broad_muscle.schema.json').read_text())
VALIDATOR = jsonschema.Draft7Validator(SCHEMA)
DOCUMENT = (Path(__file__).parents[2] / 'doc' / 'reference' / 'model_format.md').read_text()

# What a schema cannot tell: counts, names and values that have to suit others; nan
BEYOND = (
    'of the bands of the head', 'no head has', 'is no band', 'of 9 numbers expected',
    'for each band, expected, a list of 1', 'is a polynomial in s', 'finite',
    'a radius > 0 expected', 'zero', 'the lowest, then',
)  # fmt: skip
TOLD = [case for case in WRONG if not any(each in case[2] for each in BEYOND)]


def faults(model: Any) -> list[str]:
    return [error.message for error in VALIDATOR.iter_errors(model)]


def test_the_schema_is_one() -> None:
    jsonschema.Draft7Validator.check_schema(SCHEMA)


@pytest.mark.parametrize('name', bundled_models())
def test_every_bundled_model_is_valid_and_names_the_schema(name: str) -> None:
    text = bundled_models()[name]
    assert faults(yaml.safe_load(text)) == []
    first = text.splitlines()[0]
    assert first == '# yaml-language-server: $schema=broad_muscle.schema.json'
    assert (MODELS / first.partition('$schema=')[2]).is_file()


@pytest.mark.parametrize('case', MUSCLES)
def test_what_is_written_is_valid(case: str) -> None:
    assert faults(stated(MUSCLES[case]().definition)) == []


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


def keys_in(schema: Any, path: str = '') -> dict[str, tuple[set[str], set[str]]]:
    """Return the needed and the other keys of each mapping that a schema describes."""
    found: dict[str, tuple[set[str], set[str]]] = {}
    if 'properties' in schema:
        needed = set(schema['required'])
        found[path] = needed, set(schema['properties']) - needed
        for key, inner in schema['properties'].items():
            found |= keys_in(inner, f'{path}.{key}'.lstrip('.'))
    if isinstance(schema.get('additionalProperties'), dict):
        found |= keys_in(schema['additionalProperties'], f'{path}.*')
    for inner in schema.get('oneOf', ()):
        found |= keys_in(inner, path)
    return found


def test_the_schema_and_the_reader_know_the_same_keys() -> None:
    found = keys_in(SCHEMA)
    curve, points = (SCHEMA['definitions'][name]['oneOf'] for name in ('curve', 'curves'))
    found |= keys_in(curve[2], 'curve') | keys_in(points[0], 'curves')
    assert keys_in(points[1], 'curve')['curve'] == found['curve']
    assert found == {path: tuple(map(set, keys)) for path, keys in KEYS.items()}


def described() -> list[str]:
    """Return every key of the reader as the document has it."""
    paths = [(path, key) for path, keys in KEYS.items() for key in sum(keys, ())]
    own = [(path, key) for path, key in paths if path not in ('curve', 'curves')]
    return [f'{path.replace("*", "NAME")}.{key}'.lstrip('.') for path, key in own]


@pytest.mark.parametrize('key', described())
def test_every_key_is_described_in_the_document_and_in_the_schema(key: str) -> None:
    [row] = [line for line in DOCUMENT.splitlines() if line.lstrip('| *').startswith(f'`{key}`')]
    path, _, last = key.rpartition('.')
    needed = last in KEYS[path.replace('NAME', '*')][0]
    assert row.startswith(f'| **`{key}`** |' if needed else f'| `{key}` |')
    assert len(row.split('|')[2].strip()) > 2
    here: Any = SCHEMA
    for step in key.split('.'):
        if 'oneOf' in here:
            [here] = [one for one in here['oneOf'] if 'properties' in one]
        here = here['additionalProperties'] if step == 'NAME' else here['properties'][step]
    assert len(here['description']) > 5


def test_the_quantities_of_the_document_are_valid(content: Content) -> None:
    content['bands'] = {'names': ['a', 'b', 'c'], 's': [0.0, 0.5, 1.0]}
    del content['heads']
    blocks = [block.partition('```')[0] for block in DOCUMENT.split('```yaml\n')[1:]]
    for block in blocks:
        if not block.startswith('format: linkedplane_ros/subject'):
            content.update(yaml.safe_load(block) or {})
    assert 'list' in content['insertion']
    assert faults(content) == []
