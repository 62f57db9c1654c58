"""Draw the pictures of the study: moment arms beside others', bands within bone.

Run it where linkedplane_ros[all] is installed: `python doc/pictures/render_study.py`.
"""

from __future__ import annotations

from pathlib import Path

from linkedplane_ros.study.interference import PRINTED, REVERSED_Z, check
from linkedplane_ros.study.pictures import charts, figures
from linkedplane_ros.study.subject import Subject

DPI = 120
COLOURS = 64  # few make small files


def main(folder: Path) -> None:
    """Write the pictures."""
    from PIL import Image

    subject = Subject.load('deltoid')
    readings = {PRINTED: subject, REVERSED_Z: subject.read_as(REVERSED_Z)}
    checks = {name: (each, check(each.experiments)) for name, each in readings.items()}
    with figures.drawing():
        made = {'fidelity': charts.fidelity(subject), 'interference': figures.entries(checks)}
        for name, figure in made.items():
            path = folder / f'{name}.png'
            figure.savefig(path, dpi=DPI)
            with Image.open(path) as picture:
                few = picture.convert('RGB').quantize(COLOURS, dither=Image.Dither.NONE)
            few.save(path, optimize=True)


if __name__ == '__main__':
    main(Path(__file__).parent)
