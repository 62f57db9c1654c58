# SPDX-License-Identifier: Apache-2.0
"""The JSON Schema of the model file, for editors, from the keys' description.

python -m linkedplane_ros.muscle.schema  write models/broad_muscle.schema.json
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from .bones import BALL_JOINT, GROUND_FRAME, MOST_BONES, MOVING_FRAME
from .keys import ANGLE, FORMAT, KEYS, LENGTH, VERSIONS, Key, keys_below
from .parts import METRES, RADIANS
from .validity import BAND_NAME, JOINT_CENTRE, LEAST_RADIUS, LIMIT, NAME

FINITE = sys.float_info.max
FILE = Path(__file__).parents[1] / 'models' / 'broad_muscle.schema.json'

NUMBER = {'$ref': '#/definitions/number'}
POINT = {'type': 'array', 'minItems': 3, 'maxItems': 3, 'items': NUMBER}
TYPES: dict[str, dict[str, Any]] = {
    'format': {'const': FORMAT},
    'version': {'enum': list(VERSIONS)},
    'name': {'type': 'string', 'pattern': r'^\s*[A-Za-z][A-Za-z0-9_]*\s*$'},
    'names': {
        'type': 'array',
        'minItems': 1,
        'uniqueItems': True,
        'items': {'type': 'string', 'pattern': BAND_NAME},
    },
    'word': {'type': 'string', 'minLength': 1},
    'words': {
        'oneOf': [
            {'type': 'string', 'minLength': 1},
            {'type': 'array', 'minItems': 1, 'items': {'type': 'string', 'minLength': 1}},
        ]
    },
    'text': {'type': 'string', 'pattern': r'\S'},
    'number': NUMBER,
    'numbers': {'type': 'array', 'minItems': 1, 'items': NUMBER},
    'interval': {'type': 'array', 'minItems': 2, 'maxItems': 2, 'items': NUMBER},
    'point': POINT,
    'point_list': {'type': 'array', 'minItems': 1, 'items': POINT},
    'quantity': {'$ref': '#/definitions/quantity'},
    'points': {'$ref': '#/definitions/points'},
}

NAMES = {'type': 'string', 'pattern': NAME}
UNITS = {LENGTH: METRES, ANGLE: RADIANS}

# What concerns more than one key, or the names that the user gives
BEYOND_TYPES: dict[str, dict[str, Any]] = {
    'heads': {'minProperties': 1, 'propertyNames': NAMES},
    'bones.names': {
        'minItems': 2,
        'maxItems': MOST_BONES,
        'items': {
            'type': 'string',
            'pattern': rf'^(?!({MOVING_FRAME}|{GROUND_FRAME})$)[A-Za-z][A-Za-z0-9_]*$(?!\n)',
        },
    },
    'landmarks': {'propertyNames': {**NAMES, 'not': {'const': JOINT_CENTRE}}},
    'interference_spheres': {'propertyNames': NAMES},
    'reference_normal': {'contains': {'not': {'const': 0}}},
    'sphere': {
        'if': {
            'properties': {
                'frame': {
                    'anyOf': [
                        {'const': 'moving'},
                        {'type': 'array', 'contains': {'const': 'moving'}},
                    ]
                }
            }
        },
        'then': {'required': ['ground_point', 'humeral_point']},
        'else': {'properties': {'ground_point': False, 'humeral_point': False}},
    },
}


# What only later versions have
FRAME = {'enum': list(BALL_JOINT.frames)}
FIRST_VERSION: dict[str, Any] = {
    'bones': False,
    'sphere': {
        'properties': {'frame': {'oneOf': [FRAME, {'type': 'array', 'items': FRAME}]}},
    },
    'interference_spheres': {'additionalProperties': {'properties': {'bone': False}}},
    'landmarks': {
        'additionalProperties': {'properties': {'bone': {'enum': list(BALL_JOINT.names)}}},
    },
}


def json_schema() -> dict[str, Any]:
    """Return the schema, of JSON Schema's draft 7."""
    listed = describe_mapping('QUANTITY')
    points = describe_mapping('POINTS')
    point_list = points['properties'].pop('list')
    return {
        '$schema': 'http://json-schema.org/draft-07/schema#',
        'title': 'A broad muscle of linkedplane_ros',
        'description': (
            'Bands that lie in linked planes and wrap obstacle spheres; the right shoulder. '
            'Ground = scapula frame: origin at the glenohumeral centre, x lateral, y anterior, '
            'z superior; the humerus frame coincides with it when the arm hangs. '
            'See doc/reference/model_format.md.'
        ),
        **describe_mapping(''),
        'allOf': [
            {
                'if': {'properties': {'version': {'const': 1}}},
                'then': {'properties': FIRST_VERSION},
                'else': {'required': ['bones']},
            },
            *(limit_unit(key, unit) for key, units in UNITS.items() for unit in units),
        ],
        'definitions': {
            'number': {'type': 'number', 'minimum': -FINITE, 'maximum': FINITE},
            **define_limits(),
            'quantity': {
                'description': (
                    "A number: common to all bands. A list of numbers: a polynomial's coefficients "
                    'in s, highest power first. A list after the key `list`: one number for each '
                    'band.'
                ),
                'oneOf': [NUMBER, TYPES['numbers'], listed],
            },
            'points': {
                'description': (
                    'x, y and z, each common to all bands, a polynomial in s or a list; or points, '
                    'one for each band, after the key `list`.'
                ),
                'oneOf': [points, mapping({'list': point_list}, ['list'])],
            },
        },
    }


def limit_unit(unit_key: str, unit: str) -> dict[str, Any]:
    """Return the schema that limits all numbers in a unit, if the file states them in it."""
    limits: dict[str, Any] = {}
    for key in KEYS:
        if key.unit == unit_key:
            here = limits
            for name in key.path.split('.'):
                inner = here if name == 'NAME' else here.setdefault('properties', {})
                here = inner.setdefault('additionalProperties' if name == 'NAME' else name, {})
            here['$ref'] = f'#/definitions/{name_limit(key.type, key.positive)}_{unit}'
    outer, last = unit_key.split('.')
    stated = {'properties': {outer: {'properties': {last: {'const': unit}}}}}
    return {'if': stated, 'then': limits}


def name_limit(kind: str, positive: bool) -> str:
    """Return the name of the definition that limits one of TYPES, without the unit."""
    return f'positive_{kind}' if positive else kind


def define_limits() -> dict[str, Any]:
    """Return the definitions that limit each of TYPES, in each unit."""
    definitions = {}
    for unit_key, units in UNITS.items():
        for key in KEYS:
            for unit, size in units.items() if key.unit == unit_key else ():
                high = LIMIT / size
                least = {'minimum': LEAST_RADIUS / size} if key.positive else {}
                limits = limit_type(key.type, least or {'exclusiveMinimum': -high}, high)
                definitions[f'{name_limit(key.type, key.positive)}_{unit}'] = limits
    return definitions


def limit_type(kind: str, least: dict[str, float], high: float) -> dict[str, Any]:
    """Return the schema that limits the numbers of one of TYPES: by `least`, and below high."""
    number = {**least, 'exclusiveMaximum': high}
    quantity = {
        **number,
        'properties': {'list': {'items': number}},
        'if': {'type': 'array', 'maxItems': 1},  # of a polynomial, only a constant
        'then': {'items': number},
    }
    points = {**dict.fromkeys('xyz', quantity), 'list': {'items': {'items': number}}}
    of_types: dict[str, dict[str, Any]] = {
        'number': number,
        'point': {'items': number},
        'interval': {'items': number},
        'quantity': quantity,
        'points': {'properties': points},
    }
    return of_types[kind]


def describe_mapping(path: str) -> dict[str, Any]:
    """Return the schema of the mapping under a path."""
    keys = dict(keys_below(path))
    if not keys:  # of the user's own names
        return {'type': 'object', 'additionalProperties': describe_mapping(f'{path}.NAME')}
    properties = {name: describe_key(key) for name, key in keys.items()}
    return mapping(properties, [name for name, key in keys.items() if key.required])


def mapping(properties: dict[str, Any], required: list[str]) -> dict[str, Any]:
    """Return the schema of a mapping that has these keys and no other."""
    return {
        'type': 'object',
        'additionalProperties': False,
        'required': required,
        'properties': properties,
    }


def describe_key(key: Key) -> dict[str, Any]:
    """Return the schema of what is under a key."""
    frame = key.frame and f'{key.frame.strip("`")} frame'
    where = ', '.join(each for each in (key.unit and f'in {key.unit}', frame) if each)
    description = f'{key.meaning} ({where})' if where else key.meaning
    if key.choices:
        word: dict[str, Any] = {'enum': list(key.choices)}
        words = {'type': 'array', 'minItems': 1, 'items': word}
        content = {'oneOf': [word, words]} if key.type == 'words' else word
    elif key.type == 'places':
        content = {'oneOf': [describe_mapping(key.path), TYPES['numbers']]}
    else:
        content = TYPES[key.type] if key.type else describe_mapping(key.path)
    return {
        'description': description.replace('`', ''),
        **content,
        **BEYOND_TYPES.get(key.path, {}),
    }


def schema_text() -> str:
    """Return the text of the schema's file."""
    return json.dumps(json_schema(), indent=2) + '\n'


if __name__ == '__main__':
    FILE.write_text(schema_text(), encoding='utf-8')
