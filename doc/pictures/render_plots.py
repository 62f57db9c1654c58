# SPDX-License-Identifier: Apache-2.0
"""Draw what the PlotJuggler layout shows of the sample recording: each plot's series, by name.

PlotJuggler itself is not run: matplotlib draws the plots of config/deltoid_plotjuggler.xml, with
its names and colours, from the topics of a bag that `linkedplane process` wrote. Run it where
linkedplane_ros[tools] is installed: `python doc/pictures/render_plots.py [PNG]`.
"""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib

matplotlib.use('Agg')

import matplotlib.pyplot as plt
import numpy as np

from linkedplane_ros.processing.options import Options
from linkedplane_ros.processing.task import Task, run_task
from linkedplane_ros.recordings.bags.opening import open_bag
from linkedplane_ros.recordings.bags.topics import JOINT_STATE

TOP = Path(__file__).parents[2]
RAISE = TOP / 'msg_examples' / 'arm_raise'
LAYOUT = TOP / 'config' / 'deltoid_plotjuggler.xml'


def read_series(bag: Path) -> dict[str, np.ndarray]:
    """Return the points (m, 2) of each series, s and m, under PlotJuggler's name of it."""
    series = defaultdict(list)
    with closing(open_bag(bag)) as reader:
        for connection, _, data, *_ in reader.messages():
            if connection.msgtype == JOINT_STATE:
                message = reader.read_message(connection, data)
                stamp = message.header.stamp
                for joint, position in zip(message.name, message.position, strict=True):
                    name = f'{connection.topic}/{joint}/position'
                    series[name].append((stamp.sec + 1e-9 * stamp.nanosec, position))
    return {name: np.array(points) for name, points in series.items()}


def main(path: Path) -> None:
    """Write the picture."""
    with TemporaryDirectory() as folder:
        report = run_task(Task(RAISE, Path(folder) / 'raise', Options(markers=False)))
        assert not report.fault, report.fault
        series = read_series(Path(folder) / 'raise')
    areas = list(ElementTree.parse(LAYOUT).getroot().iter('DockArea'))
    plt.rcParams.update({'font.size': 9})
    figure, places = plt.subplots(len(areas), 1, figsize=(10, 9.5), sharex=True)
    for axes, area in zip(places, areas, strict=True):
        for curve in area.iter('curve'):
            times, values = series[curve.attrib['name']].T
            axes.plot(times - times[0], values, color=curve.get('color'), label=curve.get('name'))
        axes.set_title(area.get('name'), fontsize=10)
        axes.legend(loc='center left', bbox_to_anchor=(1.0, 0.5), fontsize=7, frameon=False)
        axes.grid(color='0.9')
        axes.spines[['top', 'right']].set_visible(False)
    places[-1].set(xlabel='time (s)', xlim=(0.0, None))
    figure.tight_layout()
    figure.savefig(path, dpi=80, pil_kwargs={'optimize': True})
    plt.close(figure)


if __name__ == '__main__':
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name('plots.png'))
