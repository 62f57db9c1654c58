# SPDX-License-Identifier: Apache-2.0
"""What a file is: one of the formats that are read, or another one, and what to do with that.

The content counts before the ending of the name.
"""

from __future__ import annotations

import shlex
import zipfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from ..errors import RecordingError
from .foreign_formats import FOREIGN, ForeignFormat

TABLES = ('.mot', '.sto', '.csv', '.tsv')
BAGS = ('.mcap', '.db3')
ENDINGS_READ = (*TABLES, *BAGS)
METADATA = 'metadata.yaml'  # in the folder of a bag
HEAD = 4096  # bytes that are looked at


def check_format(path: Path, endings: Sequence[str] = ENDINGS_READ) -> None:
    """Refuse a file that is of no format that is read; whether it can be read is not looked at.

    Parameters
    ----------
    path
        A file, or the folder of a bag, of which each file is looked at. What cannot be opened is
        left to whoever reads it.
    endings
        What is read.

    Raises
    ------
    RecordingError
        For a file of another content or ending; it says what the file is, and what to do.
    """
    with suppress(OSError):
        if path.is_dir():
            for each in sorted(path.iterdir()):
                of_bag = each.suffix.lower() in BAGS or each.name == METADATA
                if of_bag and each.is_file():
                    check_file(each, (*BAGS, '.yaml'))
        elif path.is_file():
            check_file(path, endings)


def check_file(path: Path, endings: Sequence[str]) -> None:
    """Refuse a file whose content or ending is not of the formats that are read."""
    with path.open('rb') as file:
        head = file.read(HEAD)
    ending = path.suffix.lower()
    if not head and ending in BAGS:
        raise RecordingError(f'{path}: the file is empty (0 bytes); a recording expected')
    foreign = foreign_content(path, head)
    if foreign is None and ending in endings:
        return
    foreign = foreign or next((each for each in FOREIGN if ending in each.endings), None)
    if foreign is not None:
        refusal = describe_refusal(path, foreign)
    elif ending in TABLES:
        refusal = 'a table, not a bag'
    else:
        refusal = f'a file of unknown format ({ending or "its name has no ending"})'
    read = ', '.join(each for each in endings if each != '.yaml')
    raise RecordingError(f'{path}: {refusal} (formats that are read: bags, {read})')


def foreign_content(path: Path, head: bytes) -> ForeignFormat | None:
    """Return the foreign format that the content of a file has; None if it has none.

    Parameters
    ----------
    path
        The file.
    head
        Its first bytes, at most HEAD.
    """
    names = list_archive(path) if head.startswith(b'PK\3\4') else []
    for each in FOREIGN:
        inside = each.within is not None and any(map(each.within.match, names))
        begins = each.content is not None and each.content.match(head)
        if (inside or begins) and each.unless != path.suffix.lower():
            return each
    return None


def list_archive(path: Path) -> list[str]:
    """Return the names in a ZIP archive; none if it is not whole."""
    try:
        with zipfile.ZipFile(path) as archive:
            return archive.namelist()
    except (OSError, ValueError, zipfile.BadZipFile):
        return []


def describe_refusal(path: Path, foreign: ForeignFormat) -> str:
    """Return the line that refuses a file of a foreign format, without its path in front."""
    advice = foreign.advice.format(file=shlex.quote(str(path)), ending=foreign.unless)
    return f'{foreign.name}; {advice}'
