# SPDX-License-Identifier: Apache-2.0
"""From what a user names (files, bags, folders, patterns) to the recordings."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from glob import glob, has_magic
from pathlib import Path

from ..errors import RecordingError
from ..recordings.formats import ENDINGS_READ, METADATA
from .options import Options
from .outputs import ENDINGS, TABLE_ENDINGS, choose_format
from .task import Task


def find_recordings(named: Iterable[str]) -> tuple[list[Path], list[str]]:
    """Return the recordings that a user named.

    Parameters
    ----------
    named
        Files, bags, folders of them, or patterns.

    Returns
    -------
    recordings, faults
        Each recording once; and a line for each name that stands for none.
    """
    paths: list[Path] = []
    faults = []
    for each in named:
        try:
            paths += match_recordings(each)
        except RecordingError as error:
            faults.append(str(error))
    return list(dict.fromkeys(paths)), faults


def match_recordings(named: str) -> list[Path]:
    """Return the recordings that a name or a pattern stands for, sorted by name."""
    path = Path(named)
    if path.is_dir() and not is_bag(path):
        paths = list(recordings_inside(path))
        if not paths:
            read = ', '.join(ENDINGS_READ)
            raise RecordingError(f'{path}: no recordings in it (bags, {read})')
        return paths
    if path.exists() or not has_magic(named):
        return [path]
    paths = []
    for match in map(Path, sorted(glob(named, recursive=True))):
        if match.is_dir() and not is_bag(match):
            paths += recordings_inside(match)
        elif is_recording(match):
            paths.append(match)
    bags = {each for each in paths if each.is_dir()}
    paths = [
        each for each in paths if each.parent not in bags
    ]  # a bag's files are not bags themselves
    if not paths:
        raise RecordingError(f'{named}: nothing matches')
    return paths


def recordings_inside(folder: Path) -> Iterator[Path]:
    """Yield the recordings of a folder, sorted by name."""
    yield from sorted(filter(is_recording, folder.iterdir()))


def is_recording(path: Path) -> bool:
    """Return whether a path looks like a recording."""
    return is_bag(path) or (not path.is_dir() and path.suffix.lower() in ENDINGS_READ)


def is_bag(path: Path) -> bool:
    """Return whether a path is a bag's folder."""
    return (path / METADATA).is_file()


def is_single(named: Sequence[str], sources: Sequence[Path], target: Path) -> bool:
    """Return whether a target is the output of one recording, and no folder of outputs.

    Where a folder or pattern stands for one recording, a table is its output; a bag's name is that
    of a folder of outputs, as it is for several.
    """
    if len(named) != 1 or len(sources) != 1:
        return False
    return sources[0] == Path(named[0]) or target.suffix.lower() in TABLE_ENDINGS


def plain_name(path: Path) -> str:
    """Return a recording's name without a file's ending; a folder has none."""
    return path.name if path.is_dir() else path.stem


def build_tasks(
    sources: Sequence[Path], target: Path, single: bool, options: Options
) -> tuple[list[Task], list[str]]:
    """Return a task for each recording.

    Parameters
    ----------
    sources
        The recordings.
    target
        The output of a single recording; else the folder of all outputs.
    single
        Whether the target is the output of one recording: see `is_single`.
    options
        How they are processed.

    Returns
    -------
    tasks, faults
        A line is a recording whose output would replace another's, or a recording.

    Raises
    ------
    RecordingError
        If the target of several recordings is a table.
    """
    if single and (not target.is_dir() or is_bag(target)):
        return keep_sources([Task(source, target, options) for source in sources], sources)
    if target.suffix.lower() in TABLE_ENDINGS:
        raise RecordingError(f'{target}: a folder expected for several recordings; --format csv?')
    choose_format(target, options.kind)  # the name of a file is none for the folder
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
    tasks, endangered = keep_sources(list(made.values()), sources)
    return tasks, faults + endangered


def keep_sources(tasks: Sequence[Task], sources: Sequence[Path]) -> tuple[list[Task], list[str]]:
    """Return the tasks that write into no source, and a line for each other one."""
    named = {source.resolve(): source for source in sources}
    safe, faults = [], []
    for task in tasks:
        target = task.target.resolve()
        touched = [
            name
            for path, name in named.items()
            if path == target or path in target.parents or target in path.parents
        ]
        if touched:
            faults.append(
                f'{task.source}: its output {task.target} is, holds or lies in the recording '
                f'{touched[0]}; another output expected'
            )
        else:
            safe.append(task)
    return safe, faults
