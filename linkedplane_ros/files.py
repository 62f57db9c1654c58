# SPDX-License-Identifier: Apache-2.0
"""Files: those that appear when they are complete, what a killed run leaves, what is read."""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
import stat
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from .errors import LinkedPlaneError

PART = '.part'  # the ending of the folder in which an output is written
INTERRUPTIONS = (KeyboardInterrupt, SystemExit)


KINDS = {  # of what is no regular file, and may never end
    stat.S_IFIFO: 'a FIFO',
    stat.S_IFSOCK: 'a socket',
    stat.S_IFCHR: 'a device',
    stat.S_IFBLK: 'a device',
}
MOST_BYTES = 2**20  # of a file that people write: a hundred times the largest model


def require_regular(path: Path, error: type[LinkedPlaneError]) -> None:
    """Refuse what is no regular file: reading it may never end, and opening it may wait for ever.

    Parameters
    ----------
    path
        The file; a link is followed. What is not there is left to whoever opens it.
    error
        What is raised for a folder, a FIFO, a socket or a device.
    """
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return
    check_mode(path, mode, error)


def check_mode(path: Path, mode: int, error: type[LinkedPlaneError]) -> None:
    """Refuse a file whose mode is not that of a regular one."""
    if stat.S_ISDIR(mode):
        raise error(f'{path}: cannot be read: {os.strerror(errno.EISDIR)}')
    if not stat.S_ISREG(mode):
        kind = KINDS.get(stat.S_IFMT(mode), 'something else')
        raise error(f'{path}: cannot be read: {kind} given, a regular file expected')


def read_small_text(path: Path, error: type[LinkedPlaneError], most_bytes: int = MOST_BYTES) -> str:
    """Return the text of a regular file of limited size.

    Parameters
    ----------
    path
        The file; a link is followed.
    error
        What is raised if it cannot be read, is not UTF-8, no regular file, or too large.
    most_bytes
        The limit of its size; no more is read.
    """
    require_regular(path, error)
    try:
        # should it have become a FIFO by now: do not wait for what writes to it
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        with open(descriptor, 'rb') as file:
            check_mode(path, os.fstat(descriptor).st_mode, error)
            content = file.read(most_bytes + 1) or b''
    except OSError as fault:
        raise error(f'{path}: cannot be read: {fault.strerror}') from None
    except ValueError as fault:  # a zero byte in the path
        if isinstance(fault, error):
            raise
        raise error(f'{path}: cannot be read: {fault}') from None
    if len(content) > most_bytes:
        raise error(
            f'{path}: cannot be read: larger than {most_bytes / 2**20:g} MiB; another file?'
        )
    try:
        return content.decode('utf-8')
    except UnicodeDecodeError:
        raise error(f'{path}: cannot be read: not UTF-8 text') from None


@contextmanager
def replace_when_complete(
    path: Path, error: type[LinkedPlaneError], may_replace: bool = True
) -> Iterator[Path]:
    """Give a path to write to, which takes the place of `path` at the end of the block.

    What was written is on the disk by then, also if the power fails. What is there before is kept
    if the block fails.

    Parameters
    ----------
    path
        Where the file or folder is to appear.
    error
        What is raised where it cannot be written, or another run is writing it.
    may_replace
        Whether a file or folder that is there is replaced; otherwise `error` is raised.
    """
    try:
        with claim_output(path, error) as workshop:
            if not may_replace and os.path.lexists(path):
                raise FileExistsError
            yield workshop / path.name  # the final name: a bag writes it into its files
            synchronise(workshop)
            move_complete(workshop / path.name, path, may_replace)
            synchronise_path(path.parent)
    except FileExistsError:
        raise error(f'{path}: exists; --force to replace it') from None
    except OSError as fault:
        raise error(f'{path}: cannot be written: {fault.strerror or fault}') from None


@contextmanager
def claim_output(path: Path, error: type[LinkedPlaneError]) -> Iterator[Path]:
    """Give a folder beside `path` to write in; `path` is this run's until the end of the block.

    The folder is removed then. One that a killed run left is emptied and used.

    Parameters
    ----------
    path
        The output.
    error
        What is raised if another run has claimed it, or the folder cannot be made.
    """
    workshop = workshop_of(path)
    try:
        lock = claim_folder(workshop)
    except BlockingIOError:
        raise error(f'{path}: another run is writing it') from None
    except OSError as fault:
        raise error(f'{path}: cannot be written: {fault.strerror or fault}') from None
    try:
        for left in workshop.iterdir():
            remove_path(left)
        yield workshop
    finally:
        remove_claimed(workshop, lock)


def claim_folder(folder: Path) -> int:
    """Make a folder if it is not there, and return its lock; an interruption leaves nothing."""
    try:
        while True:
            with suppress(FileExistsError):
                folder.mkdir(mode=0o700)
            if (lock := lock_folder(folder)) is not None:
                return lock
    except INTERRUPTIONS:  # perhaps between the folder and its lock
        with suppress(OSError):
            if (lock := lock_folder(folder)) is not None:
                remove_claimed(folder, lock)
        raise


def remove_claimed(folder: Path, lock: int) -> None:
    """Remove a folder that this process has locked, also if it is interrupted meanwhile."""
    try:
        remove_path(folder)
    except INTERRUPTIONS:
        remove_path(folder)
        raise
    finally:
        os.close(lock)


def workshop_of(path: Path) -> Path:
    """Return the folder in which an output is written before it is complete."""
    return path.with_name(f'.{path.name}{PART}')


def lock_folder(folder: Path) -> int | None:
    """Return the lock of a folder of ours; None if it is not there any more.

    Raises
    ------
    BlockingIOError
        If somebody else has the lock.
    OSError
        If it is a link, no folder, or belongs to somebody else.
    """
    try:
        lock = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    except FileNotFoundError:
        return None
    try:
        if os.fstat(lock).st_uid != os.geteuid():
            raise PermissionError(None, f'{folder} belongs to somebody else')
        take_lock(lock)
        if os.path.samestat(os.fstat(lock), folder.stat(follow_symlinks=False)):
            return lock
    except FileNotFoundError:
        pass
    except BaseException:
        os.close(lock)
        raise
    os.close(lock)
    return None


def take_lock(descriptor: int) -> None:
    """Lock an open folder until it is closed; BlockingIOError if somebody else has it."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except OSError:
        pass  # a file system without locks: the last run wins


def move_complete(new: Path, path: Path, may_replace: bool) -> None:
    """Move a file or folder to its place; FileExistsError if something is there that must stay."""
    if may_replace:
        old = new.with_name(f'{new.name}.replaced')  # a folder replaces an empty one only
        if new.is_dir() and path.is_dir():
            path.rename(old)
        try:
            new.replace(path)
        except OSError:
            if old.exists():
                old.rename(path)
            raise
        return
    try:
        if new.is_dir():
            new.rename(path)  # fails where there is more than an empty folder
        else:
            os.link(new, path)  # unlike a move, it replaces nothing
    except OSError:
        if os.path.lexists(path):
            raise FileExistsError from None
        new.rename(path)  # a file system without links


def synchronise(path: Path) -> None:
    """Wait until a file, or a folder and all in it, is on the disk."""
    for folder, _, names in os.walk(path):
        for name in names:
            synchronise_path(Path(folder, name))
        synchronise_path(Path(folder))


def synchronise_path(path: Path) -> None:
    """Wait until a file's content, or a folder's names, are on the disk."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def read_regular_file(path: Path, most: int, error: type[LinkedPlaneError]) -> bytes:
    """Return the content of a regular file of at most `most` bytes; `error` for anything else.

    A pipe or a device is refused unread: it may have no end.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        with open(descriptor, 'rb') as file:
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                raise error(f'{path}: cannot be read: not a regular file')
            content = file.read(most + 1)
    except (OSError, ValueError) as fault:
        if isinstance(fault, error):
            raise
        reason = fault.strerror if isinstance(fault, OSError) else fault
        raise error(f'{path}: cannot be read: {reason}') from None
    if len(content) > most:
        raise error(f'{path}: larger than {most / 2**20:g} MiB, the most that is read')
    return content


def find_abandoned(folders: Iterable[Path]) -> list[Path]:
    """Return what killed runs left in folders: those that nobody writes in now."""
    abandoned = []
    for folder in sorted(folders):
        for path in sorted(folder.glob(f'.*{PART}')):
            with suppress(OSError):
                if (lock := lock_folder(path)) is not None:
                    os.close(lock)
                    abandoned.append(path)
    return abandoned


def remove_path(path: Path) -> None:
    """Remove a file or a folder, if it is there."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
