"""From what a user names to the recordings: files, bags, folders and patterns of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from glob import glob, has_magic
from pathlib import Path

from ..errors import RecordingError
from .options import Options
from .outputs import ENDINGS, TABLE_ENDINGS
from .task import TABLES, Task

ENDINGS_READ = (*TABLES, '.mcap', '.db3')


def recordings(named: Iterable[str]) -> tuple[list[Path], list[str]]:
    """Return the recordings among files, bags, folders and patterns; and a line for each fault."""
    found: list[Path] = []
    faults = []
    for each in named:
        try:
            found += matching(each)
        except RecordingError as error:
            faults.append(str(error))
    return list(dict.fromkeys(found)), faults


def matching(named: str) -> list[Path]:
    """Return the recordings that a name or a pattern stands for, in the order of their names."""
    path = Path(named)
    if path.is_dir() and not is_bag(path):
        paths = list(inside(path))
        if not paths:
            read = ', '.join(ENDINGS_READ)
            raise RecordingError(f'{path}: no recordings in it (bags, {read})')
        return paths
    if path.exists() or not has_magic(named):
        return [path]
    matches = [Path(each) for each in sorted(glob(named, recursive=True))]
    paths = [
        recording
        for match in matches
        for recording in (inside(match) if match.is_dir() and not is_bag(match) else [match])
        if is_recording(recording)
    ]
    bags = {each for each in paths if each.is_dir()}
    paths = [each for each in paths if each.parent not in bags]  # a bag's files are not bags, too
    if not paths:
        raise RecordingError(f'{named}: nothing matches')
    return paths


def inside(folder: Path) -> Iterator[Path]:
    """Yield the recordings of a folder, in the order of their names."""
    yield from sorted(filter(is_recording, folder.iterdir()))


def is_recording(path: Path) -> bool:
    """Return whether a path looks like a recording."""
    return is_bag(path) or (not path.is_dir() and path.suffix.lower() in ENDINGS_READ)


def is_bag(path: Path) -> bool:
    """Return whether a path is a bag's folder."""
    return (path / 'metadata.yaml').is_file()


def plain_name(path: Path) -> str:
    """Return a recording's name without the ending of a file; a folder's name has none."""
    return path.name if path.is_dir() else path.stem


def make_tasks(
    sources: Sequence[Path], target: Path, alone: bool, options: Options
) -> tuple[list[Task], list[str]]:
    """Return a task for each recording, and a line for each that would replace another's output.

    One that stands `alone` becomes the target; others go into it as a folder.
    """
    if alone and (not target.is_dir() or is_bag(target)):
        return [Task(source, target, options) for source in sources], []
    if target.suffix.lower() in TABLE_ENDINGS:
        raise RecordingError(f'{target}: a folder expected for several recordings; --format csv?')
    kind = options.kind or 'bag'
    made: dict[Path, Task] = {}
    faults = []
    for source in sources:
        into = target / (plain_name(source) + ENDINGS[kind])
        if into in made:
            faults.append(
                f'{source}: would become {into}, as {made[into].source} does; '
                'process them into folders of their own'
            )
        else:
            made[into] = Task(source, into, replace(options, kind=kind))
    return list(made.values()), faults
