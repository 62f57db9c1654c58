"""The labels of the arrays that are published and recorded, so that they explain themselves."""

from __future__ import annotations

import math
from collections.abc import Sequence

BAND = 'band'


def dimensions(*dims: tuple[str, Sequence[str]]) -> list[tuple[str, int, int]]:
    """Return label, size and stride of each dimension of a row-major array.

    A label is a kind and its names, as in `band:anterior_1,anterior_2`; a stride is the number of
    values from its dimension inwards (MultiArrayLayout.msg).
    """
    sizes = [len(names) for _, names in dims]
    return [
        (f'{kind}:{",".join(names)}', len(names), math.prod(sizes[i:]))
        for i, (kind, names) in enumerate(dims)
    ]
