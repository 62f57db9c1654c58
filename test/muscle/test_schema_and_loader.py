# SPDX-License-Identifier: Apache-2.0
"""The JSON Schema and the loader take the same files, but for what a schema cannot say."""

from __future__ import annotations

import copy
import datetime
import math
import random
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml
from optional import requires
from spoilt_models import Content
from varied_muscles import every_variation

from linkedplane_ros import BroadMuscle, ModelError
from linkedplane_ros.muscle.broad_muscle import build_muscle
from linkedplane_ros.muscle.file import bundled_models
from linkedplane_ros.muscle.schema import json_schema
from linkedplane_ros.muscle.writing import file_content
from linkedplane_ros.muscle.yaml_mapping import YamlMapping

pytestmark = requires('jsonschema')

DOCUMENT = (Path(__file__).parents[2] / 'doc' / 'reference' / 'model_format.md').read_text()

# What the document lists: its words, and how the loader refuses it
BEYOND = {
    'a list has something for each band': r'a list of \d+ .*expected, a list of \d+ given',
    'a polynomial needs `bands.s`': r'is a polynomial in s',
    'a number that is none': r'finite number expected, nan given|nan given',
    'what a polynomial gives': r'(origin|insertion|sphere\.centre|sphere\.radius|plane_angle)'
                               r'(\[\d+\])?: .*(given.*(expected|unit\?)|a radius)',
    'every band is in one head': r'is not a band, or is one of another head|no head has the band'
                                 r'|is not one of the bands of the head',
    'a bone is one of `bones.names`': r'(bones\.\w+|frame|\.bone)(\[\d+\])?: .*one of .* expected',
    'the lowest angle comes first': r'the lowest, then the highest expected',
    'a band ends where it begins': r'ends where it begins',
    'along the first band': r'parallel to the first band',
    'in line with': r'in line with humeral_point',
}  # fmt: skip

NUMBERS = (0, 1, -1, 5.0, 9.9, 10.0, 10.1, -10, 572.9, 573.0, 999.0, 1000.0, 1001, 9999.9, 1e4,
           -1e4, 1e9, -1e300, 1e-300, 5e-324, -5e-324, 1e-9, 1e-6, 1e-4, 1e-3,
           10**400, math.inf, -math.inf, math.nan)  # fmt: skip
WORDS = ('', ' ', 'a', 'm', 'mm', 'rad', 'moving', 'ground', ' ground', 'wing', 'joint_centre',
         'one,two', 'a\n', '\ta', 'a\x00', 'a\u00a0b', '\u2028', '1e-3', 'middle_1', 'ä', '3a',
         '\U0001f4aa', 'linkedplane_ros/broad_muscle ', 'x' * 300, '_a', ' deltoid ')  # fmt: skip
OTHERS: tuple[Any, ...] = (None, True, False, [], {}, [[]], [None], ['a'], [1.0], [0, 0, 0],
                           [1.0, 2.0, 3.0], ['a', 'a'], {'list': [1.0]}, {'list': []}, {'list': 1},
                           {'first': 0.0, 'last': 1.0}, {'ground': 1}, {1: 2}, {'': 1},
                           datetime.date(2024, 1, 1), b'bytes', {1.5}, ['ground'] * 9)  # fmt: skip
KEYS = ('x', 'list', '', 'joint_centre', 'radius', 1, 1.5, True, None, datetime.date(2024, 1, 1),
        'a\nb', ' ')  # fmt: skip


def places(content: Any) -> Iterator[tuple[Any, Any]]:
    """Yield every mapping and list within, with each of its keys."""
    keys = list(content) if isinstance(content, dict) else range(len(content))
    for key in keys:
        yield content, key
        if isinstance(content[key], (dict, list)):
            yield from places(content[key])


def mutate(content: Content, dice: random.Random) -> None:
    """Change one thing of a model."""
    here, key = dice.choice(list(places(content)))
    kind = dice.randrange(9)
    if kind == 0:
        del here[key]
    elif kind == 1 and isinstance(here, dict):
        here[dice.choice(KEYS)] = copy.deepcopy(here[key])
    elif kind == 2 and isinstance(here, dict):
        here[dice.choice(KEYS)] = here.pop(key)
    elif kind == 3 and isinstance(here[key], list):
        here[key].append(copy.deepcopy(dice.choice(here[key] or [1.0])))
    elif kind <= 5 and isinstance(here[key], (int, float)) and abs(here[key]) < 1e300:
        here[key] = here[key] * dice.choice((0, -1, 10, 1e2, 1e3, 1e6, 1e300))
    else:
        here[key] = copy.deepcopy(dice.choice((*NUMBERS, *WORDS, *OTHERS)))


def models() -> list[Content]:
    """Return models with all that a file may state."""
    bundled: list[Content] = [yaml.safe_load(text) for text in bundled_models().values()]
    return [*bundled, file_content(every_variation())]


def refusal(content: Content) -> str:
    """Return why the loader refuses a model; empty if it does not."""
    try:
        build_muscle(YamlMapping('model', '', content))
    except ModelError as error:
        return str(error)
    return ''


@pytest.mark.parametrize('seed', range(10))
def test_schema_and_loader_take_the_same_models(seed: int) -> None:
    from jsonschema import Draft7Validator

    judge = Draft7Validator(json_schema())
    dice = random.Random(seed)
    originals = models()
    taken = refused = beyond = 0
    for _ in range(200):
        content = copy.deepcopy(dice.choice(originals))
        for _ in range(dice.choice((1, 1, 2))):
            mutate(content, dice)
        valid, reason = judge.is_valid(content), refusal(content)
        if valid and reason:
            assert any(re.search(pattern, reason) for pattern in BEYOND.values()), reason
            beyond += 1
        else:
            assert valid == (not reason), next(judge.iter_errors(content)).message
            taken, refused = taken + valid, refused + (not valid)
    assert taken > 10
    assert refused > 50


@pytest.mark.parametrize('unit', ['m', 'cm', 'mm'])
@pytest.mark.parametrize('place', ['sphere', 'interference_spheres'])
def test_both_have_the_same_least_radius_and_take_the_least_numbers_elsewhere(
    place: str, unit: str
) -> None:
    from jsonschema import Draft7Validator

    judge = Draft7Validator(json_schema())
    least = {'m': 1e-6, 'cm': 1e-4, 'mm': 1e-3}[unit]
    content = copy.deepcopy(models()[0])
    if unit == 'm':
        content = file_content(replace(BroadMuscle.load('deltoid'), source='in metres').definition)
    content['units']['length'] = unit
    spheres = content[place]
    sphere = spheres if place == 'sphere' else next(iter(spheres.values()))
    for radius, taken in ((least, True), (5e-324, False), (0.999 * least, False)):
        sphere['radius'] = radius
        assert (judge.is_valid(content), not refusal(content)) == (taken, taken), radius
    assert 'a radius of at least 1e-06 m expected' in refusal(content)
    sphere['radius'] = least
    sphere['centre'] = [5e-324] * 3 if place != 'sphere' else dict.fromkeys('xyz', 5e-324)
    content['reference_normal'] = [0.0, 5e-324, 0.0]
    content['range_of_motion'] = {key: [0, 5e-324] for key in content['range_of_motion']}
    assert (judge.is_valid(content), refusal(content)) == (True, '')


@pytest.mark.parametrize('words', BEYOND)
def test_what_a_schema_cannot_say_is_listed(words: str) -> None:
    listed = DOCUMENT.partition('What a schema cannot say')[2].partition('\n## ')[0]
    assert words in ' '.join(listed.split())
