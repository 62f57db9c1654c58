# SPDX-License-Identifier: Apache-2.0
"""Draw the pictures of the study: moment arms beside others', bands within bone.

Run it where linkedplane_ros[all] is installed: `python doc/pictures/render_study.py`.
"""

from __future__ import annotations

from pathlib import Path

from linkedplane_ros.drawing.figure_files import house_style
from linkedplane_ros.study.interference import PRINTED, REVERSED_Z, check_experiments
from linkedplane_ros.study.pictures import charts, poses
from linkedplane_ros.study.subject import Subject

DPI = 120
COLOURS = 64  # few make small files


def main(folder: Path) -> None:
    """Write the pictures."""
    from PIL import Image

    subject = Subject.load('deltoid')
    readings = {PRINTED: subject, REVERSED_Z: subject.with_frame_reading(REVERSED_Z)}
    checks = {name: (each, check_experiments(each.experiments)) for name, each in readings.items()}
    with house_style():
        made = {
            'fidelity': charts.fidelity_figure(subject),
            'interference': poses.entries_figure(checks),
        }
        for name, figure in made.items():
            path = folder / f'{name}.png'
            figure.savefig(path, dpi=DPI)
            with Image.open(path) as picture:
                few = picture.convert('RGB').quantize(COLOURS, dither=Image.Dither.NONE)
            few.save(path, optimize=True)


if __name__ == '__main__':
    main(Path(__file__).parent)
