# SPDX-License-Identifier: Apache-2.0
"""One word has one meaning: a public class, function or type has a name of its own."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator

import house
import pytest

PER_MODULE = {'main', 'run', 'add_arguments', 'build_parser'}  # of executables and commands
TYPE = re.compile(r'[A-Z]\w*[a-z]\w*')  # constants are in capitals, and belong to their module
SOURCES = {
    str(file.relative_to(house.SOURCES)): file.read_text(encoding='utf-8')
    for file in house.SOURCES.rglob('*.py')
}


def public_names(source: str) -> Iterator[str]:
    """Yield the names of the classes, functions and types that a module defines at its top."""
    for node in ast.parse(source).body:
        if isinstance(node, ast.Assign):
            names = [each.id for each in node.targets if isinstance(each, ast.Name)]
            yield from filter(TYPE.fullmatch, names)
        elif isinstance(node, (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            yield from [node.name][node.name.startswith('_') :]


def repeated_names(sources: dict[str, str]) -> set[str]:
    """Return the names that more than one module defines."""
    counts = Counter(name for source in sources.values() for name in {*public_names(source)})
    return {name for name, count in counts.items() if count > 1} - PER_MODULE


def test_a_public_name_is_defined_once() -> None:
    assert repeated_names(SOURCES) == set()


@pytest.mark.parametrize(
    ('file', 'line', 'name'),
    [
        ('muscle/parts.py', 'class Sphere:\n    pass', 'Sphere'),
        ('linked_planes/path.py', 'BandRow = list[float]', 'BandRow'),
        ('viewer/app.py', 'def unit_vector() -> None: ...', 'unit_vector'),
    ],
)
def test_a_second_meaning_is_found(file: str, line: str, name: str) -> None:
    assert repeated_names({**SOURCES, file: f'{SOURCES[file]}\n\n{line}\n'}) == {name}
