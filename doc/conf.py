# SPDX-License-Identifier: Apache-2.0
"""The documentation, built by Sphinx: `make docs` does so here, rosdoc2 for docs.ros.org."""

from __future__ import annotations

import re
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst import Directive
from pygments.lexers.special import TextLexer
from sphinx.util.inspect import TypeAliasForwardRef

import linkedplane_ros

TOP = Path(linkedplane_ros.__file__).parents[1]
sys.path.insert(0, str(TOP / 'doc'))

import house  # noqa: E402

from linkedplane_ros import types  # noqa: E402

project = 'linkedplane_ros'
author = copyright = 'The linkedplane_ros maintainers'
version = release = linkedplane_ros.__version__
extensions = ['myst_parser', 'sphinx.ext.autodoc', 'sphinx.ext.napoleon', 'sphinx.ext.viewcode']

# Pages are Markdown as GitHub shows it: its formulas, and its anchors of headings.
myst_enable_extensions = ['dollarmath', 'deflist']
myst_fence_as_directive = ['math']
myst_heading_anchors = 4

default_role = 'code'  # `this`, in a docstring
autodoc_member_order = 'bysource'
autodoc_typehints_format = 'short'
autodoc_type_aliases = {name: name for name in vars(types) if name[0].isupper()}
autodoc_type_aliases['npt.ArrayLike'] = 'ArrayLike'
TypeAliasForwardRef.__repr__ = lambda alias: alias.name  # in a tuple, too
napoleon_google_docstring = False
python_use_unqualified_type_names = True
# Types of other libraries have no page here; names of ours are found or are a warning.
nitpick_ignore_regex = [
    ('py:.*', r'(?!linkedplane_ros\b).*'),
    ('py:class', r'linkedplane_ros\.\w+\..*'),
]

html_theme = 'furo' if find_spec('furo') else 'alabaster'
html_theme_options: dict[str, str] = {}
html_static_path = ['static']
html_css_files = ['pages.css']
html_title = f'{project} {release}'
rosdoc2_settings = {'override_theme': False}
exclude_patterns = [
    'index.rst',
    'README.md',
    'CONTRIBUTING.md',
    'CHANGELOG.rst',
    '__*.rst',
]  # rosdoc2's


def as_on_github(app: Any, page: str, source: list[str]) -> None:
    """Read what GitHub has another way: formulas $`...`$ in a line, links to files out of here."""

    def outside(link: re.Match[str]) -> str:
        stays = (Path(app.srcdir, page).parent / link[1]).resolve().is_relative_to(app.srcdir)
        return link[0] if stays else f'](<path:{link[1]}>)'

    text = source[0].replace('$`', '$').replace('`$', '$')
    source[0] = re.sub(r'\]\((\.\./[^)#:]+\.md)(#[^)]*)?\)', outside, text)


def numbered(app: Any, page: nodes.document) -> None:
    r"""Make every formula an equation: MathJax numbers no other (\tag{1})."""
    for formula in page.findall(nodes.math_block):
        formula['nowrap'] = formula['no-wrap'] = True
        body = re.sub(r'\n\s*\n', '\n', formula.astext())
        formula[:] = [nodes.Text(f'\\begin{{equation}}{body}\\end{{equation}}')]


def neighbours(app: Any) -> None:
    """Give the copy of this folder that rosdoc2 builds what pages link to outside of it."""
    for name in ('CONTRIBUTING.md', 'config', project):
        place = Path(app.srcdir).parent / name
        if not place.exists():
            place.symlink_to(TOP / name)


def whole(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Keep a docstring's words: `(n)` begins no list, and no type stands before a colon."""
    lines[:] = [re.sub(r'^( *)(\(\w\))', r'\1\\\2', line) for line in lines]
    if what in ('attribute', 'property') and lines:
        lines[0] = f': {lines[0]}'


def readable(
    app: Any, what: str, name: str, thing: Any, options: Any, signature: str | None, returns: str
) -> tuple[str | None, str]:
    """Return a signature in which Sphinx finds its types, also of a dataclass's made defaults."""
    return signature and signature.replace('<factory>', '...'), returns


class House(Directive):
    """The picture of the packages and their imports, as they are at this build."""

    def run(self) -> list[nodes.Node]:
        """Return the picture."""
        return [nodes.raw('', house.picture(), format='html')]


def setup(app: Any) -> None:
    """Add what is ours to Sphinx."""
    app.add_directive('house', House)
    app.connect('builder-inited', neighbours)
    app.connect('source-read', as_on_github)
    app.add_lexer('csv', TextLexer)
    app.connect('autodoc-process-docstring', whole, priority=400)
    app.connect('autodoc-process-signature', readable)
    app.connect('doctree-read', numbered)
