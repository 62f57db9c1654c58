# SPDX-License-Identifier: Apache-2.0
"""The pages that a user reads: the README, CONTRIBUTING and the documentation."""

from __future__ import annotations

import re
from pathlib import Path

TOP = Path(__file__).parents[2]
PAGES = [TOP / 'README.md', TOP / 'CONTRIBUTING.md', *sorted((TOP / 'doc').rglob('*.md'))]
NAMES = [page.relative_to(TOP).as_posix() for page in PAGES]


def without_blocks(text: str) -> str:
    """Return a page without its blocks of code."""
    return re.sub(r'^ *```.*?^ *```$', '', text, flags=re.MULTILINE | re.DOTALL)


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub makes them."""
    heads = re.findall(r'^#+ (.*)$', without_blocks(page.read_text('utf-8')), re.MULTILINE)
    return {re.sub(r'[^\w\- ]', '', head.lower()).replace(' ', '-') for head in heads}
