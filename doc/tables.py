# SPDX-License-Identifier: Apache-2.0
"""The tables of the pages that the code has: parameters, topics, commands, conventions, keys.

    python doc/tables.py  write them again into the README and the pages, and say into which

A table stands between <!-- name --> and <!-- /name -->. The tests fail where one is out of date.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from linkedplane_ros import JOINT_CONVENTIONS
from linkedplane_ros.commands.main import build_parser
from linkedplane_ros.drawing.markdown import markdown_table
from linkedplane_ros.muscle import keys
from linkedplane_ros.node import parameters, topics
from linkedplane_ros.recordings.foreign_formats import FOREIGN
from linkedplane_ros.recordings.tables.times import PLAIN_TIMES, UNITS
from linkedplane_ros.types import Floats

TOP = Path(__file__).parents[1]
PAGES = (TOP / 'README.md', *sorted((TOP / 'doc').rglob('*.md')))
ELBOW, FOREARM = np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0])


def joint_conventions() -> str:
    """Return what each joint convention is, and what its streams usually measure against."""
    return markdown_table(
        ('convention', 'coordinates', 'rotation', 'usually against'),
        (
            (f'`{name}`', ', '.join(each.coordinates), each.formula, each.relative_to)
            for name, each in JOINT_CONVENTIONS.items()
        ),
    )


def direction(R: Floats, vector: Floats) -> str:
    """Return a turned vector."""
    return ', '.join(f'{value:.3f}' for value in np.round(R @ vector, 3) + 0.0)


def single_angles() -> str:
    """Return where 30 deg of each angle by itself take the arm."""
    rows = [
        ('' if j else f'`{name}`', coordinate, direction(R, ELBOW), direction(R, FOREARM))
        for name, convention in JOINT_CONVENTIONS.items()
        for j, coordinate in enumerate(convention.coordinates)
        for R in [convention.rotation(np.radians(30.0) * np.eye(3)[j])]
    ]
    return markdown_table(('convention', '+30 deg of', 'elbow', 'forearm'), rows)


def three_angles() -> str:
    """Return where 30, 60 and 20 deg at once take the arm."""
    rows = [
        (f'`{name}`', direction(R, ELBOW), direction(R, FOREARM))
        for name, convention in JOINT_CONVENTIONS.items()
        for R in [convention.rotation(np.radians([30.0, 60.0, 20.0]))]
    ]
    return markdown_table(('convention', 'elbow', 'forearm'), rows)


TOPIC = ('topic', 'type', 'quality of service', 'content')


def subscribed() -> str:
    """Return what the node subscribes."""
    wanted = (topics.JOINT_STATES, topics.ROBOT_DESCRIPTION, topics.TF, topics.TF_STATIC)
    return markdown_table(TOPIC, topics.topic_rows((*wanted, topics.CLOCK)))


def published() -> str:
    """Return what the node publishes."""
    rows = topics.topic_rows((*topics.OUTPUTS, *topics.BONE_OUTPUTS), 'deltoid/')
    return markdown_table(TOPIC, [*rows, *topics.topic_rows((topics.DIAGNOSTICS,))])


def contents() -> str:
    """Return the topics for the README: what is on each."""
    rows = topics.topic_rows((topics.JOINT_STATES,))
    rows += topics.topic_rows(topics.OUTPUTS, 'deltoid/')
    return markdown_table(
        ('topic', 'type', 'content'), ((name, kind, what) for name, kind, _, what in rows)
    )


def node_parameters() -> str:
    """Return the parameters of the node."""
    return markdown_table(('name', 'default', 'meaning'), parameters.parameter_rows())


def model_keys() -> str:
    """Return what may stand in a model file."""
    rows = []
    for key in keys.KEYS:
        kind = keys.TYPES.get(key.type, '')
        if key.choices:
            words = ', '.join(f'`{word}`' for word in key.choices)
            kind = kind.replace('a word', f'one of {words}')
        where = ', '.join(each for each in (key.unit and f'`{key.unit}`', key.frame) if each)
        name = f'**`{key.path}`**' if key.required else f'`{key.path}`'
        rows.append((name, kind, where, key.meaning))
    return markdown_table(('key', 'type', 'unit, frame', 'meaning'), rows)


def named(action: argparse.Action, formatter: argparse.HelpFormatter) -> str:
    """Return an argument as one writes it."""
    words = formatter._format_args(action, action.dest.upper()) if action.nargs != 0 else ''
    return f'`{f"{action.option_strings[-1]} {words}".strip() if action.option_strings else words}`'


def command(name: str, parser: argparse.ArgumentParser) -> Iterator[str]:
    """Yield a command's part of the page: how it is written, and what each argument means."""
    formatter = parser._get_formatter()
    arguments = [action for action in parser._actions if action.dest != 'help']
    usage = [
        named(each, formatter).strip('`')
        for each in arguments
        if each.required or not each.option_strings
    ]
    yield f'## {name}'
    yield parser.description or ''
    yield f'```text\nlinkedplane {" ".join((name, *usage))} [options]\n```'
    for group in parser._action_groups:
        rows = [
            (named(each, formatter), formatter._expand_help(each))
            for each in group._group_actions
            if each in arguments
        ]
        if rows:
            title = {'positional arguments': 'argument', 'options': 'option'}
            yield markdown_table((title.get(group.title or '', group.title or ''), 'meaning'), rows)


def commands() -> str:
    """Return every command with its arguments."""
    [choices] = [
        action.choices
        for action in build_parser()._actions
        if isinstance(action, argparse._SubParsersAction)
    ]
    return '\n\n'.join(part for name, each in choices.items() for part in command(name, each))


def foreign_formats() -> str:
    """Return the formats of recordings that are not read."""
    rows = [
        (
            each.name,
            ', '.join(f'`{ending}`' for ending in each.endings),
            each.advice.format(file='FILE', ending=f'`{each.unless}`'),
        )
        for each in FOREIGN
    ]
    return markdown_table(('what a file is called', 'endings', 'what to do'), rows)


def plain_times() -> str:
    """Return the names of a time, the first that is there counting."""
    return ', '.join(f'`{name}`' for name in PLAIN_TIMES)


def time_units() -> str:
    """Return the names of each unit of a time."""
    names: dict[float, list[str]] = {}
    for name, per_second in UNITS.items():
        names.setdefault(per_second, []).append(f'`{name}`')
    rows = ((f'{1.0 / each:g} s', ', '.join(names[each])) for each in names)
    return markdown_table(('unit', 'in the name'), rows)


TABLES: dict[str, Callable[[], str]] = {
    'commands': commands,
    'conventions': joint_conventions,
    'foreign formats': foreign_formats,
    'model keys': model_keys,
    'parameters': node_parameters,
    'plain times': plain_times,
    'published': published,
    'single angles': single_angles,
    'subscribed': subscribed,
    'three angles': three_angles,
    'time units': time_units,
    'topics': contents,
}


def renew(text: str) -> str:
    """Return a page with its tables as they are now."""
    for name in re.findall(r'^<!-- (\w[\w ]*) -->$', text, re.MULTILINE):
        if name in TABLES:
            head, _, rest = text.partition(f'<!-- {name} -->\n')
            foot = f'<!-- /{name} -->'
            text = f'{head}<!-- {name} -->\n{TABLES[name]()}\n{foot}{rest.partition(foot)[2]}'
    return text


def main() -> int:
    """Write the tables."""
    for page in PAGES:
        before = page.read_text(encoding='utf-8')
        after = renew(before)
        if after != before:
            page.write_text(after, encoding='utf-8')
            print(page.relative_to(TOP))
    return 0


if __name__ == '__main__':
    sys.exit(main())
