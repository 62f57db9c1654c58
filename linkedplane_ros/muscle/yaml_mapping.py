# SPDX-License-Identifier: Apache-2.0
"""YAML that people write: an error is one line with file, key and reason."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from datetime import date
from itertools import chain
from pathlib import Path
from typing import Any

import yaml

from ..errors import LONGEST, LinkedPlaneError, ModelError, describe_value
from ..files import read_small_text

SURROGATE = re.compile('[\ud800-\udfff]')  # half a character, as "\ud800" in YAML


MOST_VALUES = 10_000  # of a file: more take longer than anyone waits
DEEPEST = 20  # levels, the values in the last list counted
LONGEST_NUMBER = 1000  # characters
INTEGER = re.compile('[-+]?(0|[1-9][0-9]*)|0x[0-9a-fA-F]+')  # the same in YAML 1.1 and 1.2


class StrictLoader(yaml.SafeLoader):
    """YAML without keys that appear twice, endless numbers, and values without end.

    A few lines of aliases of aliases are a value that no memory holds.
    """

    def __init__(self, stream: str) -> None:
        """Begin to count the values."""
        super().__init__(stream)
        self._values = self._depth = 0

    def get_single_node(self) -> yaml.Node | None:
        """Return the node of the text; a YAML error if its aliases make too much of it."""
        node: yaml.Node | None = super().get_single_node()
        if node is not None and count_values(node, {}) > MOST_VALUES:
            raise yaml.MarkedYAMLError(problem=f'more than {MOST_VALUES} values by aliases (*)')
        return node

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Return the next node; a YAML error if there were too many, or it is too deep."""
        self._values += 1
        if self._values > MOST_VALUES:
            raise yaml.MarkedYAMLError(problem=f'more than {MOST_VALUES} values')
        if self._depth >= DEEPEST:
            raise yaml.MarkedYAMLError(problem=f'nested too deeply, more than {DEEPEST} levels')
        self._depth += 1
        node: yaml.Node | None = super().compose_node(parent, index)
        self._depth -= 1
        return node

    def compose_scalar_node(self, anchor: Any) -> yaml.ScalarNode:
        """Return the next scalar; a YAML error at a number or a text that no file should have."""
        node = super().compose_scalar_node(anchor)
        if node.tag.endswith((':int', ':float')) and len(node.value) > LONGEST_NUMBER:
            problem = f'a number of {len(node.value)} characters'
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=node.start_mark)
        if is_ambiguous(node):
            problem = (
                f'{describe_value(node.value)} is a number in YAML 1.1 that 1.2 reads otherwise; '
                'write it in decimal without leading zeros, : and _ (text: in quotes)'
            )
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=node.start_mark)
        if SURROGATE.search(node.value):
            problem = f'{describe_value(node.value)} is not Unicode'
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=node.start_mark)
        return node

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        """Return the value of a node; a YAML error if it is not what its tag says."""
        try:
            return super().construct_object(node, deep)
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
            if not isinstance(node, yaml.ScalarNode):
                raise
        kind = node.tag.rpartition(':')[2]
        problem = f'a value cannot be read: {describe_value(node.value)} is no {kind}'
        raise yaml.MarkedYAMLError(problem=problem, problem_mark=node.start_mark)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Return the mapping; a YAML error at the second of two like keys."""
        keys = set()
        for key_node, _ in node.value:
            key = key_node.value if isinstance(key_node, yaml.ScalarNode) else None
            if key in keys:
                problem = f'the key {describe_value(key)} appears twice'
                raise yaml.MarkedYAMLError(problem=problem, problem_mark=key_node.start_mark)
            keys.add(key)
        return super().construct_mapping(node, deep)


def is_ambiguous(node: yaml.ScalarNode) -> bool:
    """Return whether a number is another one, or text, in YAML 1.2: octal, base 60, with _."""
    if node.tag.endswith(':int'):
        return bool(node.value) and not INTEGER.fullmatch(node.value)
    return node.tag.endswith(':float') and any(each in node.value for each in ':_')


def count_values(node: yaml.Node, known: dict[int, float]) -> float:
    """Return how many values a node has, each alias counted as what it stands for.

    Infinite for a node in itself; `known` has the counts of the nodes that were seen.
    """
    if id(node) not in known:
        known[id(node)] = math.inf  # should it be met again within itself
        inner = node.value if isinstance(node, yaml.CollectionNode) else ()
        nodes = chain.from_iterable(inner) if isinstance(node, yaml.MappingNode) else inner
        known[id(node)] = 1.0 + sum(count_values(each, known) for each in nodes)
    return known[id(node)]


def load_yaml(text: str) -> Any:
    """Return what a YAML text says; LinkedPlaneError with line and problem if it is not valid."""
    try:
        return yaml.load(text, StrictLoader)
    except yaml.YAMLError as error:
        mark = getattr(error, 'problem_mark', None)
        line = f' at line {mark.line + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or str(error).split('\n')[0]
    except RecursionError:
        line, problem = '', 'nested too deeply'
    except Exception as error:  # PyYAML's, of a value that is not what its tag says
        line, problem = '', f'a value cannot be read: {error}'
    raise LinkedPlaneError(f'not valid YAML{line}: {problem}')


def parse_yaml(file: str, text: str) -> YamlMapping:
    """Return the content of a file; ModelError if it is not YAML, or not a mapping."""
    try:
        content = load_yaml(text)
    except LinkedPlaneError as error:
        raise ModelError(f'{file}: {error}') from None
    return YamlMapping(file, '', content)


def read_yaml(path: Path) -> YamlMapping:
    """Return the content of a file; ModelError if it cannot be read, or is not a mapping."""
    return parse_yaml(str(path), read_small_text(path, ModelError))


class YamlMapping:
    """A mapping of a file, which knows its place there; every error names file and key."""

    def __init__(self, file: str, path: str, content: Any) -> None:
        """Hold a mapping; ModelError for anything else."""
        self.file, self.path = file, path
        if not isinstance(content, Mapping):
            where = path or 'the file'
            raise ModelError(
                f'{file}: {where}: a mapping of keys expected, {describe_kind(content)} given'
            )
        self.content = content

    def __contains__(self, key: str) -> bool:
        return key in self.content

    def fault(self, key: str, reason: str) -> ModelError:
        """Return the error for one of the mapping's keys."""
        return ModelError(f'{self.file}: {self.full_key(key)}: {reason}')

    def full_key(self, key: str) -> str:
        """Return the full, dotted name of a key."""
        shown = key if key.isprintable() and len(key) <= LONGEST else describe_value(key)
        return f'{self.path}.{shown}' if self.path else shown

    def check_keys(self, required: Iterable[str], optional: Iterable[str] = ()) -> None:
        """Refuse missing and unknown keys."""
        required, optional = list(required), list(optional)
        missing = [key for key in required if key not in self.content]
        if missing:
            raise self.fault(missing[0], 'missing')
        unknown = [key for key in self.content if key not in required + optional]
        if unknown:
            known = ', '.join(required + optional)
            key = unknown[0] if isinstance(unknown[0], str) else describe_value(unknown[0])
            raise self.fault(key, f'unknown key; known here: {known}')

    def mapping(self, key: str) -> YamlMapping:
        """Return the mapping under a key."""
        return YamlMapping(self.file, self.full_key(key), self.content[key])

    def mappings(self, key: str) -> list[tuple[str, YamlMapping]]:
        """Return the mappings under a key by their names; none where the key is not there."""
        if key not in self.content:
            return []
        named = self.mapping(key)
        for name in named.content:
            if not isinstance(name, str):
                raise self.fault(key, f'names expected, {describe_kind(name)} given{QUOTES}')
        return [(name, named.mapping(name)) for name in named.content]

    def text(self, key: str) -> str:
        """Return the non-empty text under a key."""
        value = self.content[key]
        if not isinstance(value, str) or not value.strip():
            given = describe_value(value) if isinstance(value, str) else describe_kind(value)
            raise self.fault(key, f'text expected, {given} given{quotes_hint(value)}')
        return value.strip()

    def names(self, key: str) -> tuple[str, ...]:
        """Return the list of names under a key."""
        value = self.content[key]
        if not isinstance(value, list):
            raise self.fault(key, f'a list of names expected, {describe_kind(value)} given')
        for i, name in enumerate(value):
            if not isinstance(name, str):
                given = f'{describe_kind(name)} given{quotes_hint(name)}'
                raise self.fault(f'{key}[{i}]', f'a list of names expected, {given}')
        return tuple(value)

    def choice(self, key: str, choices: Iterable[str]) -> str:
        """Return the word under a key, one of the choices."""
        value, choices = self.content[key], tuple(choices)
        if not isinstance(value, str) or value not in choices:
            given = describe_value(value)
            raise self.fault(key, f'{given} given, one of {", ".join(choices)} expected')
        return value

    def number(self, key: str) -> float:
        """Return the finite number under a key."""
        return self._number(key, self.content[key])

    def numbers(self, key: str, count: int | None = None) -> tuple[float, ...]:
        """Return the list of finite numbers under a key, `count` of them if that is given."""
        return self._numbers(key, self.content[key], count)

    def point(self, key: str) -> tuple[float, float, float]:
        """Return the three numbers under a key."""
        x, y, z = self.numbers(key, 3)
        return x, y, z

    def points(self, key: str) -> list[tuple[float, ...]]:
        """Return the list of points, three numbers each, under a key."""
        value = self.content[key]
        if not isinstance(value, list) or not value:
            raise self.fault(
                key, f'a list of points, one for each band, expected, {describe_kind(value)} given'
            )
        return [self._numbers(f'{key}[{i}]', row, 3) for i, row in enumerate(value)]

    def _numbers(self, key: str, value: Any, count: int | None) -> tuple[float, ...]:
        expected = f'a list of {count} numbers' if count else 'a list of numbers'
        if not isinstance(value, list) or not value or (count and len(value) != count):
            given = f'a list of {len(value)}' if isinstance(value, list) else describe_kind(value)
            raise self.fault(key, f'{expected} expected, {given} given')
        return tuple(self._number(f'{key}[{i}]', v) for i, v in enumerate(value))

    def _number(self, key: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            given = f'{describe_value(value)} given{number_hint(value)}'
            raise self.fault(key, f'a number expected, {given}')
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self.fault(key, f'a finite number expected, {number} given')
        return number


def is_version(value: Any, version: int) -> bool:
    """Return whether a value is the number of a version; `true`, which Python takes for 1, not."""
    return not isinstance(value, bool) and bool(value == version)


def number_hint(value: Any) -> str:
    """Return how to write text such as 1e-3, which YAML 1.1 does not take for a number."""
    exponential = r'[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)[eE][-+]?[0-9]+'
    is_number = isinstance(value, str) and re.fullmatch(exponential, value)
    return '; write 1.0e-3, not 1e-3' if is_number else ''


def describe_kind(value: Any) -> str:
    """Return what a value of a file is called in a message."""
    if value is None:
        return 'nothing'
    if isinstance(value, date):
        return f'the date {value}'
    kinds: dict[Any, str] = {dict: 'a mapping', list: 'a list', str: 'text'}
    return kinds.get(type(value), describe_value(value))


QUOTES = '; what YAML takes for a number, a date, true or nothing is text in quotes'


def quotes_hint(value: Any) -> str:
    """Return how to write a value as text; empty for what is no single value."""
    return QUOTES if isinstance(value, (bool, int, float, date)) else ''
