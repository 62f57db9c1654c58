# SPDX-License-Identifier: Apache-2.0
"""The tables of the pages are what the code says."""

from __future__ import annotations

import re

import pytest
import tables
from pages import NAMES, TOP

from linkedplane_ros.joints.joint_state import REASONS


@pytest.mark.parametrize('name', NAMES)
def test_the_tables_of_a_page_are_up_to_date(name: str) -> None:
    page = (TOP / name).read_text(encoding='utf-8')
    assert page == tables.renew(page), 'run: python doc/tables.py'


def test_every_table_stands_on_a_page() -> None:
    pages = ''.join((TOP / name).read_text(encoding='utf-8') for name in NAMES)
    for name in tables.TABLES:
        assert re.search(f'^<!-- {name} -->\n\\S', pages, re.MULTILINE), name


def test_every_reason_why_a_message_is_not_used_is_documented() -> None:
    page = (TOP / 'doc' / 'reference' / 'topics.md').read_text(encoding='utf-8')
    rows = page.partition('## When a message is not used')[2].partition('\n## ')[0]
    assert tuple(re.findall(r'^\| `(\w+)` \|', rows, re.MULTILINE)) == REASONS
