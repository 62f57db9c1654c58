# SPDX-License-Identifier: Apache-2.0
"""Files that appear when they are complete, and files that disappear."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from .errors import LinkedPlaneError


@contextmanager
def replace_when_complete(path: Path, error: type[LinkedPlaneError]) -> Iterator[Path]:
    """Give a file to write to, which takes the place of `path` at the end of the block.

    Parameters
    ----------
    path
        Where the file is to appear; what is there before is kept if the block fails.
    error
        What is raised where the file cannot be written.
    """
    part = path.with_name(f'.{path.name}.{os.getpid()}.part')
    try:
        yield part
        os.replace(part, path)
    except OSError as fault:
        raise error(f'{path}: cannot be written: {fault.strerror or fault}') from None
    finally:
        with suppress(OSError):  # where there is nothing to remove
            part.unlink()


def remove_path(path: Path) -> None:
    """Remove a file or a folder, if it is there."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
