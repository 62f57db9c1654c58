# SPDX-License-Identifier: Apache-2.0
"""YAML that people write: an error is one line with file, key and reason."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import yaml

from ..errors import ModelError, describe_value


class UniqueKeyLoader(yaml.SafeLoader):
    """YAML in which no key of a mapping may appear twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Return the mapping; a YAML error at the second of two like keys."""
        keys = set()
        for key_node, _ in node.value:
            key = key_node.value if isinstance(key_node, yaml.ScalarNode) else None
            if key in keys:
                problem = f'the key {key!r} appears twice'
                raise yaml.MarkedYAMLError(problem=problem, problem_mark=key_node.start_mark)
            keys.add(key)
        return super().construct_mapping(node, deep)


def read_text(path: Path) -> str:
    """Return the text of a file; ModelError if it cannot be read."""
    try:
        return path.read_text(encoding='utf-8')
    except UnicodeDecodeError:
        raise ModelError(f'{path}: cannot be read: not UTF-8 text') from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise ModelError(f'{path}: cannot be read: {reason}') from None


def parse_yaml(file: str, text: str) -> YamlMapping:
    """Return the content of a file; ModelError if it is not YAML, or not a mapping."""
    try:
        content = yaml.load(text, UniqueKeyLoader)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        mark = getattr(error, 'problem_mark', None)
        line = f' at line {mark.line + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or str(error).split('\n')[0]
        raise ModelError(f'{file}: not valid YAML{line}: {problem}') from None
    return YamlMapping(file, '', content)


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
        shown = key if key.isprintable() else repr(key)
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
            raise self.fault(str(unknown[0]), f'unknown key; known here: {known}')

    def mapping(self, key: str) -> YamlMapping:
        """Return the mapping under a key."""
        return YamlMapping(self.file, self.full_key(key), self.content[key])

    def mappings(self, key: str) -> list[tuple[str, YamlMapping]]:
        """Return the mappings under a key by their names; none where the key is not there."""
        if key not in self.content:
            return []
        named = self.mapping(key)
        return [(str(name), named.mapping(name)) for name in named.content]

    def text(self, key: str) -> str:
        """Return the non-empty text under a key."""
        value = self.content[key]
        if not isinstance(value, str) or not value.strip():
            given = repr(value) if isinstance(value, str) else describe_kind(value)
            raise self.fault(key, f'text expected, {given} given')
        return value.strip()

    def names(self, key: str) -> tuple[str, ...]:
        """Return the list of names under a key."""
        value = self.content[key]
        if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
            raise self.fault(key, f'a list of names expected, {describe_kind(value)} given')
        return tuple(value)

    def choice(self, key: str, choices: Iterable[str]) -> str:
        """Return the word under a key, one of the choices."""
        value, choices = self.content[key], tuple(choices)
        if not isinstance(value, str) or value not in choices:
            raise self.fault(key, f'{value!r} given, one of {", ".join(choices)} expected')
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
            hint = '; write 1.0e-3, not 1e-3' if is_exponential(value) else ''
            raise self.fault(key, f'a number expected, {describe_value(value)} given{hint}')
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self.fault(key, f'a finite number expected, {number} given')
        return number


def is_exponential(value: Any) -> bool:
    """Return whether a value is text such as 1e-3, which YAML 1.1 does not take for a number."""
    return isinstance(value, str) and re.fullmatch(r'[-+]?[\d.]+[eE][-+]?\d+', value) is not None


def describe_kind(value: Any) -> str:
    """Return what a value of a file is called in a message."""
    if value is None:
        return 'nothing'
    kinds: dict[Any, str] = {dict: 'a mapping', list: 'a list', str: 'text'}
    return kinds.get(type(value), repr(value))
