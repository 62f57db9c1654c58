"""Compile the solver's kernels with numba where it is installed; the same source runs without it.

Setting the environment variable LINKEDPLANE_COMPILE to 0 keeps them uncompiled.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

# divisions as in C; a product and a sum in one instruction, where the machine has one
OPTIONS: dict[str, Any] = {'error_model': 'numpy', 'fastmath': {'contract'}}

Kernel = TypeVar('Kernel', bound=Callable[..., Any])

_sources: set[str] = set()  # the files that kernels stand in

try:
    if os.environ.get('LINKEDPLANE_COMPILE') == '0':
        raise ImportError('compilation is switched off')
    import numba
    from numba.extending import register_jitable
except ImportError:
    COMPILED = False
else:
    COMPILED = True


def compiled(kernel: Kernel) -> Kernel:
    """Return a kernel that other kernels call: compiled into them, plain Python for Python."""
    if not COMPILED:
        return kernel
    _sources.add(kernel.__code__.co_filename)
    return register_jitable(**OPTIONS)(kernel)  # type: ignore[no-any-return]


def entry(kernel: Kernel) -> Kernel:
    """Return a kernel that Python calls: it lets other threads run, and is cached on disk.

    Beside the source, or in the user's cache folder where that is read-only, or, with neither to
    write to, not at all.
    """
    if not COMPILED:
        return kernel
    _sources.add(kernel.__code__.co_filename)
    try:
        return numba.njit(nogil=True, cache=True, **OPTIONS)(kernel)  # type: ignore
    except RuntimeError:
        return numba.njit(nogil=True, **OPTIONS)(kernel)  # type: ignore


def fingerprint() -> str:
    """Return a name for the present state of the files with kernels that were loaded so far.

    numba renews a cached kernel when its own file changes, but not when one that it calls does. A
    kernel that closes over this name is cached under it, too.
    """
    digest = hashlib.sha256()
    for source in sorted(_sources):
        digest.update(Path(source).read_bytes())
    return digest.hexdigest()
