# SPDX-License-Identifier: Apache-2.0
"""Compile the solver's kernels with numba where it is installed; the same source runs without it.

Setting the environment variable LINKEDPLANE_COMPILE to 0 keeps them uncompiled.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
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
    from numba.core.caching import FunctionCache
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
    write to, not at all. It is compiled again when any kernel that it calls has changed.
    """
    if not COMPILED:
        return kernel
    called = numba.njit(nogil=True, **OPTIONS)(kernel)
    with suppress(RuntimeError):  # no folder to write to
        called._cache = _Cache(kernel)
    return called  # type: ignore[no-any-return]


if COMPILED:

    class _Cache(FunctionCache):  # type: ignore[misc]
        """Renewed when anything changes that a kernel uses; numba looks only at its own file."""

        @cached_property
        def _sources(self) -> str:
            return fingerprint(self._py_func)

        def _index_key(self, signature: Any, codegen: Any) -> tuple[Any, ...]:
            return (*super()._index_key(signature, codegen), self._sources)


def fingerprint(kernel: Callable[..., Any]) -> str:
    """Return a digest of all that a kernel is compiled from.

    The files of the kernel, of the kernels that it calls and of the types that it makes, and the
    constants that they use, wherever they stand.
    """
    files, constants = set(), set()
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
