"""Compile the solver's kernels with numba where it is installed; the same source runs without it."""

import os
from collections.abc import Callable
from typing import Any, TypeVar

Kernel = TypeVar('Kernel', bound=Callable[..., Any])

try:
    if os.environ.get('LINKEDPLANE_COMPILE', '1') == '0':
        raise ImportError
    import numba
except ImportError:
    COMPILED = False
else:
    COMPILED = True


def compiled(kernel: Kernel) -> Kernel:
    """Return the kernel compiled for the machine, or itself where numba is missing."""
    if not COMPILED:
        return kernel
    return numba.njit(error_model='numpy')(kernel)  # type: ignore[no-any-return]
