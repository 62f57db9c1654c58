# SPDX-License-Identifier: Apache-2.0
"""The README: a sitting long, and its figures are those of the pages that it leads to."""

from __future__ import annotations

import re

import pytest
from pages import TOP

import linkedplane_ros

README = (TOP / 'README.md').read_text(encoding='utf-8')
IN_SHORT = README.partition('## In short\n')[2].partition('\n## ')[0].strip().split('\n\n')


def test_the_readme_has_at_most_200_lines() -> None:
    assert len(README.splitlines()) <= 200


@pytest.mark.parametrize('paragraph', IN_SHORT, ids=lambda text: text[2:].partition('.')[0])
def test_every_figure_stands_on_the_page_that_a_paragraph_leads_to(paragraph: str) -> None:
    [link] = re.findall(r'\]\(([\w/.]+)\)', paragraph)
    page = (TOP / link).read_text(encoding='utf-8')
    for figure in re.findall(r'\d[\d,.]*\d|\d', paragraph.partition('](')[0]):
        assert re.search(rf'(?<![\d.,]){re.escape(figure)}(?![\d]|[.,]\d)', page), figure


def test_the_citation_has_the_version() -> None:
    assert f'version = {{{linkedplane_ros.__version__}}}' in README
