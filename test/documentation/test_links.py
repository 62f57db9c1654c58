# SPDX-License-Identifier: Apache-2.0
"""Every link of a page leads to a file, and to a heading where it names one."""

from __future__ import annotations

import re

import pytest
from pages import NAMES, TOP, anchors, without_blocks


@pytest.mark.parametrize('name', NAMES)
def test_every_link_of_a_page_leads_somewhere(name: str) -> None:
    page = TOP / name
    for target in re.findall(r'\]\(([^)\s]+)\)', without_blocks(page.read_text('utf-8'))):
        if '://' in target:
            continue
        place, _, anchor = target.partition('#')
        file = (page.parent / place).resolve() if place else page
        assert file.exists(), target
        assert not anchor or anchor in anchors(file), target
