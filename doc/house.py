"""The house: the packages of linkedplane_ros in the way of the data, and who imports whom.

    python doc/house.py              say which imports break the rules; exit status 1 if any does
    python doc/house.py PICTURE.svg  draw the packages and their arrows

A package imports only from those before it. ROS is met in three packages alone, and libraries that
not everybody has are imported where they are used, so that everything else works without them.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

SOURCES = Path(__file__).parents[1] / 'linkedplane_ros'
PACKAGES = {
    'linked_planes': "the thesis's chapter 4",
    'joints': 'joint states to poses',
    'muscle': 'a model and its file',
    'solver': 'a muscle at a pose',
    'drawing': 'a state as shapes and pictures',
    'recordings': 'motion from files',
    'processing': 'recordings with muscle states',
    'node': 'topics, parameters, messages',
    'fit': 'a model from measurements',
    'rivals': 'other methods',
    'study': "the thesis's chapter 5",
    'viewer': 'the muscle in a browser',
    'commands': 'the command line',
}
ROOT = ('errors', 'types')  # modules that everything may import
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
    at_once = set(tree.body)
    for statement in tree.body:
        if isinstance(statement, ast.Try):
            at_once |= set(statement.body)
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


def is_of_ros(name: str) -> bool:
    """Return whether a library is one of ROS: rclpy, launch, or messages."""
    return name in {'launch', 'rclpy'} or name.endswith(('_msgs', '_interfaces', '_ros'))


def faults(sources: Path = SOURCES) -> Iterator[str]:
    """Yield a line for each import that breaks the rules."""
    order = list(PACKAGES)
    for folder in sources.iterdir():
        if folder.is_dir() and any(folder.rglob('*.py')) and folder.name not in order:
            yield f'{folder.name}: a package that doc/house.py does not know'
    for package in order:
        for file in sorted((sources / package).rglob('*.py')):
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


if __name__ == '__main__':
    lines = list(faults())
    print(*lines, sep='\n', end='\n' * bool(lines))
    sys.exit(bool(lines))
