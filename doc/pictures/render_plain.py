# SPDX-License-Identifier: Apache-2.0
"""Draw moment arms against an angle from a plain table of the sample recording, by column name.

matplotlib draws what any tool can that reads `linkedplane process --plain`. Run it where
linkedplane_ros[tools] is installed: `python doc/pictures/render_plain.py [PNG]`.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib

matplotlib.use('Agg')

import matplotlib.pyplot as plt

from linkedplane_ros import BroadMuscle
from linkedplane_ros.drawing.colours import HEAD_COLOURS
from linkedplane_ros.processing.options import Options
from linkedplane_ros.processing.task import Task, run_task

RAISE = Path(__file__).parents[2] / 'msg_examples' / 'arm_raise'
ANGLE = 'angles/abduction'


def main(path: Path) -> None:
    """Write the picture."""
    with TemporaryDirectory() as folder:
        table = Path(folder) / 'raise.csv'
        report = run_task(Task(RAISE, table, Options(plain=True)))
        assert not report.fault, report.fault
        with table.open(newline='', encoding='utf-8') as file:
            rows = list(csv.DictReader(file))
    plt.rcParams.update({'font.size': 9})
    figure, axes = plt.subplots(figsize=(7.5, 4.2))
    for head, colour in zip(BroadMuscle.load('deltoid').heads, HEAD_COLOURS, strict=False):
        column = f'moment_arms/{head.represented_by}/abduction'
        angles, arms = ([float(row[name]) for row in rows] for name in (ANGLE, column))
        axes.plot(angles, arms, color=colour, label=column)
    axes.set(xlabel=f'{ANGLE} (rad)', ylabel='moment arm (m)')
    axes.legend(frameon=False)
    axes.grid(color='0.9')
    axes.spines[['top', 'right']].set_visible(False)
    figure.tight_layout()
    figure.savefig(path, dpi=100, pil_kwargs={'optimize': True})
    plt.close(figure)


if __name__ == '__main__':
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name('plain.png'))
