# SPDX-License-Identifier: Apache-2.0
"""The house: the packages of linkedplane_ros in the way of the data, and who imports whom.

    python doc/house.py              say which imports break the rules; exit status 1 if any does
    python doc/house.py PICTURE.svg  draw the packages and their arrows

A package imports only from those before it. Only three packages import ROS, and libraries that not
everybody has are imported where they are used, so that everything else works without them.
"""

from __future__ import annotations

import ast
import sys
from collections import Counter
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import NamedTuple

SOURCES = Path(__file__).parents[1] / 'linkedplane_ros'
PACKAGES = {  # in the way of the data: the column where it is drawn, and what it is
    'linked_planes': (1, "the thesis's chapter 4"),
    'joints': (0, 'joint states to poses'),
    'skeleton': (3, 'a chain of joints'),
    'muscle': (2, 'a model and its file'),
    'solver': (1, 'a muscle at a pose'),
    'drawing': (1, 'a state as shapes and pictures'),
    'recordings': (0, 'motion from files'),
    'processing': (0, 'recordings with muscle states'),
    'node': (0, 'topics, parameters, messages'),
    'fit': (1, 'a model from measurements'),
    'rivals': (2, 'other methods'),
    'study': (2, "the thesis's chapter 5"),
    'viewer': (0, 'the muscle in a browser'),
    'commands': (1, 'the command line'),
}
ROOT = ('errors', 'files', 'libraries', 'types')  # modules that everything may import
WITH_ROS = ('node', 'viewer', 'commands')
LAZY = {  # library: the package that may import it at the top of a module
    'matplotlib': '', 'scipy': '', 'pyarrow': '', 'pymoo': '', 'rosbags': '', 'rich': '',
    'dask': '', 'viser': 'viewer',
}  # fmt: skip


class Import(NamedTuple):
    """One import of a module: what, and whether the module cannot be loaded without it."""

    file: Path
    line: int
    name: str
    at_once: bool


def imports(file: Path) -> Iterator[Import]:
    """Yield every import of a file; ours by their full name, without the dots of relative ones."""
    package = file.parts[file.parts.index(SOURCES.name) :][:-1]
    tree = ast.parse(file.read_text(encoding='utf-8'))
    at_once = set(loaded_with(tree))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) + 1 - node.level] if node.level else ()
            stem = '.'.join((*base, *filter(None, [node.module])))
            names = [stem, *(f'{stem}.{alias.name}' for alias in node.names)][node.module is None :]
        else:
            continue
        for name in names:
            yield Import(file, node.lineno, name, node in at_once)


def loaded_with(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the statements that are run when a module is loaded; not what is for type checkers."""
    for child in ast.iter_child_nodes(node):
        for_types = isinstance(child, ast.If) and 'TYPE_CHECKING' in ast.unparse(child.test)
        if not for_types and not isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef)):
            yield child
            yield from loaded_with(child)


def is_of_ros(name: str) -> bool:
    """Return whether a library is one of ROS: rclpy, launch, or messages."""
    return name in {'launch', 'rclpy'} or name.endswith(('_msgs', '_interfaces', '_ros'))


def faults(sources: Path = SOURCES) -> Iterator[str]:
    """Yield a line for each import that breaks the rules."""
    order = [*ROOT, *PACKAGES]
    for entry in sources.iterdir():
        python = entry.suffix == '.py' or (entry.is_dir() and any(entry.rglob('*.py')))
        if python and entry.stem not in (*order, '__init__'):
            yield f'{entry.name}: a package or module that doc/house.py does not know'
    for package in order:
        root = sources / f'{package}.py'  # of the modules in the root
        for file in [root] if root.is_file() else sorted((sources / package).rglob('*.py')):
            for found in imports(file):
                where = f'{file.relative_to(sources.parent)}:{found.line}: {package} imports'
                library, *path = found.name.split('.')
                if library == SOURCES.name:
                    other = path[0] if path else ''
                    if other in order[order.index(package) + 1 :]:
                        yield f'{where} {other}, a later package'
                elif is_of_ros(library) and package not in WITH_ROS:
                    yield f'{where} {library}; ROS belongs in {", ".join(WITH_ROS)}'
                elif found.at_once and LAZY.get(library, package) != package:
                    yield f'{where} {library} at its top; import it where it is used'


def arrows(sources: Path = SOURCES) -> Counter[tuple[str, str]]:
    """Return how many modules of a package import from another one, for each such pair."""
    pairs = {
        (file, package, name[1])
        for package in PACKAGES
        for file in (sources / package).rglob('*.py')
        for name in (found.name.split('.') for found in imports(file))
        if name[0] == SOURCES.name and name[1:] and name[1] in PACKAGES and name[1] != package
    }
    return Counter((package, other) for _, package, other in pairs)


def floors(pairs: Counter[tuple[str, str]]) -> dict[str, int]:
    """Return the floor of each package: one above the highest of those that it imports from."""
    floor: dict[str, int] = {}
    for package in PACKAGES:
        below = [floor[other] for one, other in pairs if one == package and other in floor]
        floor[package] = max(below, default=-1) + 1
    return floor


def direct(pairs: Counter[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the arrows that do not follow from others, by way of a third package."""
    below = {package: {other for one, other in pairs if one == package} for package in PACKAGES}
    reach: dict[str, set[str]] = {}
    for package in PACKAGES:
        reach[package] = below[package].union(*(reach[other] for other in below[package]))
    return [
        (package, other)
        for package in PACKAGES
        for other in PACKAGES
        if other in below[package] and not any(other in reach[by] for by in below[package])
    ]


WIDE, HIGH, ACROSS, UP = 216, 50, 268, 98  # px: a box, and from one to the next
STYLE = """
  .house text { font: 12px system-ui, sans-serif; fill: currentColor; text-anchor: middle }
  .house .name { font: 600 15px ui-monospace, monospace }
  .house rect { fill: #4c8bb8; fill-opacity: .14; stroke: #4c8bb8; stroke-width: 1.5 }
  .house .ros rect { fill: #c8783c; stroke: #c8783c }
  .house path { fill: none; stroke: currentColor; stroke-opacity: .75 }
  .house marker path { fill: currentColor; stroke: none }
"""


def picture(sources: Path = SOURCES) -> str:
    """Return the house as an SVG: a box for each package, an arrow to each that it stands on."""
    pairs = arrows(sources)
    floor = floors(pairs)
    top = max(floor.values())
    columns = max(column for column, _ in PACKAGES.values())

    def middle(package: str) -> tuple[float, float]:
        x = 10 + WIDE / 2 + ACROSS * PACKAGES[package][0]
        return x, 10 + HIGH / 2 + UP * (top - floor[package])

    lines = []
    for package, other in direct(pairs):
        (x, y), (to_x, to_y) = middle(package), middle(other)
        lean = (to_x - x) / ACROSS
        x, y, to_x, to_y = x + 40 * lean, y + HIGH / 2, to_x - 40 * lean, to_y - HIGH / 2 - 6
        turn = y + 0.42 * (UP - HIGH)  # aside between the first two floors, then straight down
        path = f'M{x:g} {y:g} C{x:g} {turn:g} {to_x:g} {turn:g} {to_x:g} {y + UP - HIGH - 18:g}'
        size = 1.0 + 0.25 * min(pairs[package, other], 10)
        lines.append(
            f'<path d="{path} V{to_y:g}" stroke-width="{size:g}" marker-end="url(#tip)">'
            f'<title>{package} imports {other}: {pairs[package, other]} modules</title></path>'
        )
    for package, (_, meaning) in PACKAGES.items():
        x, y = middle(package)
        lines.append(
            f'<g class="{"ros" if package in WITH_ROS else "plain"}">'
            f'<rect x="{x - WIDE / 2:g}" y="{y - HIGH / 2:g}" width="{WIDE}" height="{HIGH}"/>'
            f'<text class="name" x="{x:g}" y="{y - 4:g}">{package}</text>'
            f'<text x="{x:g}" y="{y + 15:g}">{escape(meaning)}</text></g>'
        )
    wide, high = 20 + WIDE + ACROSS * columns, 20 + HIGH + UP * top
    tip = '<path d="M0 0 L11 4.5 L0 9 z"/>'
    marker = 'markerUnits="userSpaceOnUse" markerWidth="11" markerHeight="9" refX="7" refY="4.5"'
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="house" viewBox="0 0 {wide} {high}" '
        f'width="{wide}" role="img" aria-label="The packages and what each imports">'
        f'<style>{STYLE}</style>'
        f'<defs><marker id="tip" {marker} orient="auto">{tip}</marker></defs>'
    )
    return '\n'.join((head, *lines, '</svg>\n'))


def main(words: list[str]) -> int:
    """Draw the house, or say what breaks its rules; return the exit status."""
    if words:
        Path(words[0]).write_text(picture(), encoding='utf-8')
        return 0
    lines = list(faults())
    print(*lines, sep='\n', end='\n' * bool(lines))
    return bool(lines)


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
