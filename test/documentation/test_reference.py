# SPDX-License-Identifier: Apache-2.0
"""The reference of Python has exactly the names that are public; rosdoc2 finds the pages."""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from collections.abc import Callable, Iterator
from typing import Any
from xml.etree import ElementTree

import pytest
import yaml
from pages import TOP

import linkedplane_ros
from linkedplane_ros import rivals
from linkedplane_ros.solver.states import Answer


@pytest.mark.parametrize(
    ('page', 'names'),
    [('python.md', linkedplane_ros.__all__), ('rivals.md', rivals.__all__)],
)
def test_the_page_has_every_public_name_once(page: str, names: list[str]) -> None:
    text = (TOP / 'doc' / 'reference' / page).read_text(encoding='utf-8')
    shown = re.findall(r'^\.\. auto(?:class|data|exception|function):: (\w+)$', text, re.MULTILINE)
    assert sorted(shown) == sorted(names)


def public_functions() -> Iterator[tuple[str, Callable[..., Any]]]:
    """Yield the methods of what is exported, with their names."""
    exported = [
        getattr(place, name) for place in (linkedplane_ros, rivals) for name in place.__all__
    ]
    for owner in filter(inspect.isclass, [*exported, Answer]):
        for name, member in vars(owner).items():
            function = getattr(member, '__func__', member)
            if inspect.isfunction(function) and not name.startswith('_'):
                yield f'{owner.__name__}.{name}', function


def missing_parts(function: Callable[..., Any]) -> set[str]:
    """Return the parts that a docstring needs and does not have."""
    signature = inspect.signature(function)
    needed = {
        'Parameters': bool(signature.parameters.keys() - {'self'}),
        'Returns': signature.return_annotation not in (None, 'None'),
        'Raises': any(isinstance(node, ast.Raise) for node in ast.walk(parse(function))),
    }
    text = inspect.getdoc(function) or ''
    return {part for part in needed if needed[part] and f'\n{part}\n---' not in text}


def parse(function: Callable[..., Any]) -> ast.AST:
    return ast.parse(textwrap.dedent(inspect.getsource(function)))


def test_what_is_exported_says_what_it_takes_returns_and_raises() -> None:
    missing = {name: missing_parts(function) for name, function in public_functions()}
    assert len(missing) > 20
    assert {name: parts for name, parts in missing.items() if parts} == {}


def test_a_docstring_of_one_line_lacks_its_parts() -> None:
    def scale(points: float) -> float:
        """Return points."""
        raise ValueError

    assert missing_parts(scale) == {'Parameters', 'Returns', 'Raises'}


def test_rosdoc2_is_led_to_the_pages() -> None:
    export = ElementTree.parse(TOP / 'package.xml').getroot().find('export/rosdoc2')
    assert export is not None
    kind, config = yaml.safe_load_all((TOP / str(export.text)).read_text(encoding='utf-8'))
    assert kind == {'type': 'rosdoc2 config', 'version': 1}
    [builder] = config['builders']
    assert (TOP / builder['sphinx']['sphinx_sourcedir'] / 'conf.py').exists()
