# SPDX-License-Identifier: Apache-2.0
"""No damaged table is read differently from what stands in it: a part of `make soak`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from table_fuzz import damage, find_faults, write_table


def test_no_damaged_table_is_read_differently(tmp_path: Path) -> None:
    faults, read = find_faults(tmp_path, 150, seed=5)
    assert faults == []
    assert 30 <= read <= 100  # neither all refused nor all passed


def test_the_same_seed_damages_the_same_tables() -> None:
    one, other = (np.random.default_rng(3) for _ in range(2))
    assert damage(one, write_table(one)[1]) == damage(other, write_table(other)[1])
