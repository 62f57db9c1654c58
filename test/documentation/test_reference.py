"""The reference of Python has exactly the names that are public."""

from __future__ import annotations

import re

import pytest
from pages import TOP

import linkedplane_ros
from linkedplane_ros import rivals


@pytest.mark.parametrize(
    ('page', 'names'),
    [('python.md', linkedplane_ros.__all__), ('rivals.md', rivals.__all__)],
)
def test_the_page_has_every_public_name_once(page: str, names: list[str]) -> None:
    text = (TOP / 'doc' / 'reference' / page).read_text(encoding='utf-8')
    shown = re.findall(r'^\.\. auto(?:class|data|exception|function):: (\w+)$', text, re.MULTILINE)
    assert sorted(shown) == sorted(names)
