# SPDX-License-Identifier: Apache-2.0
"""The tables of a study."""

from __future__ import annotations

import csv
from pathlib import Path


def read_table(folder: Path, table: str) -> list[dict[str, str]]:
    """Return the rows of one of a study's tables."""
    with (folder / 'tables' / f'{table}.csv').open(newline='') as file:
        return list(csv.DictReader(file))
