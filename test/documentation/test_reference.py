# SPDX-License-Identifier: Apache-2.0
"""The reference of Python has exactly the names that are public; rosdoc2 finds the pages."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest
import yaml
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


def test_rosdoc2_is_led_to_the_pages() -> None:
    export = ElementTree.parse(TOP / 'package.xml').getroot().find('export/rosdoc2')
    assert export is not None
    kind, config = yaml.safe_load_all((TOP / str(export.text)).read_text(encoding='utf-8'))
    assert kind == {'type': 'rosdoc2 config', 'version': 1}
    [builder] = config['builders']
    assert (TOP / builder['sphinx']['sphinx_sourcedir'] / 'conf.py').exists()
