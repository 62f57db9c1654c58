# SPDX-License-Identifier: Apache-2.0
"""Compile the solver's kernels with numba where it is installed; the same source runs without it.

Setting the environment variable LINKEDPLANE_COMPILE to 0 keeps them uncompiled.
"""

from __future__ import annotations

import hashlib
import logging
import os
import pickle
import sys
from collections.abc import Callable, Iterator
from functools import cached_property
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, TypeVar

# divisions as in C; a product and a sum in one instruction, where the machine has one
OPTIONS: dict[str, Any] = {'error_model': 'numpy', 'fastmath': {'contract'}}

Kernel = TypeVar('Kernel', bound=Callable[..., Any])

try:
    if os.environ.get('LINKEDPLANE_COMPILE') == '0':
        raise ImportError('compilation is switched off')
    import numba
    from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache
    from numba.extending import register_jitable
except ImportError:
    COMPILED = False
else:
    COMPILED = True


def compiled(kernel: Kernel) -> Kernel:
    """Return a kernel that other kernels call: compiled into them, plain Python for Python."""
    if not COMPILED:
        return kernel
    return register_jitable(**OPTIONS)(kernel)  # type: ignore[no-any-return]


def entry(kernel: Kernel) -> Kernel:
    """Return a kernel that Python calls: it lets other threads run, and is cached on disk.

    Beside the source, or in the user's cache folder where that is read-only, or, with neither to
    write to, not at all. It is compiled again when any kernel that it calls has changed, and when
    the cache cannot be read.
    """
    if not COMPILED:
        return kernel
    called = numba.njit(nogil=True, **OPTIONS)(kernel)
    try:
        called._cache = _Cache(kernel)
    except (OSError, RuntimeError):
        called._cache = _NoCache()
    return called  # type: ignore[no-any-return]


WARNED: set[str] = set()


def warn_once(problem: str, where: str = '') -> None:
    """Log a warning, the first time that there is this problem: a process has many kernels."""
    if problem not in WARNED:
        WARNED.add(problem)
        line = f'{where}: {problem}' if where else problem
        logging.getLogger(__name__.partition('.')[0]).warning('%s', line)


if COMPILED:

    class _NoCache(NullCache):  # type: ignore[misc]
        """Where no folder can be written to."""

        def save_overload(self, signature: Any, compiled: Any) -> None:
            warn_once('kernels are compiled at each start: no folder to keep them can be written')

    class _CacheFile(IndexDataCacheFile):  # type: ignore[misc]
        """With each entry its digest: machine code that is damaged must not run."""

        def save(self, key: Any, data: Any) -> None:
            content = self._dump(data)
            super().save(key, (digest_entry(key, content), content))

        def load(self, key: Any) -> Any:
            stored = super().load(key)
            if stored is None:
                return None
            digest, content = stored
            if digest != digest_entry(key, content):
                raise ValueError('damaged')
            return pickle.loads(content)

    class _Cache(FunctionCache):  # type: ignore[misc]
        """Renewed when anything changes that a kernel uses; numba looks only at its own file."""

        def __init__(self, kernel: Callable[..., Any]) -> None:
            super().__init__(kernel)
            stamp = self._impl.locator.get_source_stamp()
            file = _CacheFile(self.cache_path, self._impl.filename_base, stamp)
            self._cache_file: Any = file

        @cached_property
        def _sources(self) -> str:
            return fingerprint(self._py_func)

        def _index_key(self, signature: Any, codegen: Any) -> tuple[Any, ...]:
            return (*super()._index_key(signature, codegen), self._sources)

        def load_overload(self, signature: Any, context: Any) -> Any:
            try:
                return super().load_overload(signature, context)
            except Exception:  # unpickling what is damaged raises anything
                warn_once('damaged compiled kernels; they are compiled again', self.cache_path)
            try:
                self.flush()
            except OSError:
                self.disable()
            return None

        def save_overload(self, signature: Any, compiled: Any) -> None:
            try:
                super().save_overload(signature, compiled)
            except OSError as error:
                reason = f'compiled kernels cannot be kept: {error.strerror or error}'
                warn_once(reason, self.cache_path)


def digest_entry(key: Any, content: bytes) -> bytes:
    """Return the digest of a kernel's machine code and what it was compiled for."""
    return hashlib.sha256(repr(key).encode() + content).digest()


def fingerprint(kernel: Callable[..., Any]) -> str:
    """Return a digest of all that a kernel is compiled from.

    The files of the kernel, of the kernels that it calls and of the types that it makes, the
    constants that they use, wherever they stand, and this file, which has the options.
    """
    files: set[Any] = {__file__}
    constants = set()
    seen: set[Any] = set()
    left: list[Any] = [kernel]
    while left:
        used = left.pop()
        used = getattr(used, 'py_func', used)  # of a compiled kernel
        if isinstance(used, (int, float, str, tuple)):
            constants.add(repr(used))
        elif isinstance(used, (FunctionType, type)) and used not in seen:
            seen.add(used)
            files.add(getattr(sys.modules[used.__module__], '__file__', None))
            left += globals_used(used) if isinstance(used, FunctionType) else []
    digest = hashlib.sha256('\n'.join(sorted(constants)).encode())
    for file in sorted(filter(None, files)):
        digest.update(Path(file).read_bytes())
    return digest.hexdigest()


def globals_used(function: FunctionType) -> Iterator[Any]:
    """Yield the values of the names that a function takes from its module, or closes over."""
    for cell in function.__closure__ or ():
        yield cell.cell_contents
    codes = [function.__code__]
    for code in codes:
        codes += [each for each in code.co_consts if isinstance(each, CodeType)]
        yield from (
            function.__globals__[name] for name in code.co_names if name in function.__globals__
        )
