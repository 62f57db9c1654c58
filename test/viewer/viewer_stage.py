# SPDX-License-Identifier: Apache-2.0
"""The node, the viewer and a page of a real browser, over the loopback device."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
from browser import CHROMIUM, WINDOW, Page, wait_until
from optional import is_installed
from ros_harness import LEFT, NodeProcess

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, MuscleState
from linkedplane_ros.libraries import advise_install

MISSING = next(
    (f'{what} is not installed: {cure}' for what, there, cure in (
        ('chromium', CHROMIUM, 'apt-get install chromium'),
        ('playwright', is_installed('playwright'), 'pip install playwright'),
        ('viser', is_installed('viser'), advise_install('viser')),
    ) if not there),
    '',
)  # fmt: skip
DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
TOPICS = '--topic', '/joint_states', '--topic', '/left/joint_states'
DRAWN = 1e-7  # m: coordinates below 0.25 m in single precision


class ViewerProcess(NodeProcess):
    """The viewer as users run it; its output is kept."""

    def __init__(self, log: Path, *arguments: str) -> None:
        """Start it on a port that is free, and wait until it says where it listens."""
        self.log = log
        command = [sys.executable, '-m', 'linkedplane_ros.viewer', '--port', '0', *arguments]
        with log.open('wb') as out:
            self.process = subprocess.Popen(command, stdout=out, stderr=out)
        LEFT.append(self.process)
        assert wait_until(lambda: 'open http' in self.text or self.process.poll() is not None)
        found = re.search(r'open (http\S+)', self.text)
        assert found, self.text
        self.url = found.group(1)


class Stage:
    """The node, the viewer and a page of the browser."""

    def __init__(self, folder: Path, chromium: Any) -> None:
        self.folder = folder
        self.chromium = chromium
        self.start_node(folder / 'node.log')
        self.viewer = ViewerProcess(folder / 'viewer.log', *TOPICS, '--take')
        self.viewer.outlive_test()
        self.page = self.open()
        self.page.press_button('neutral')  # nothing is published before
        assert wait_until(lambda: len(self.page.lines()) > 0), self.viewer.text

    def start_node(self, log: Path) -> None:
        self.node = NodeProcess(log, **{'markers.rate': 0.0})
        self.node.outlive_test()

    def open(self, dpr: float = 0.3) -> Page:
        return Page(self.chromium.new_page(viewport=WINDOW), self.viewer.url, dpr)

    def shows(self, state: MuscleState, page: Page | None = None) -> bool:
        """Wait until the scene of a page is that of a state; return whether it was."""
        return shows_state(page or self.page, state)


def shows_state(page: Page, state: MuscleState, name: str = '/deltoid/bands/lines') -> bool:
    """Wait until the lines of a name in a page's scene are a state's; return whether they were."""
    paths = [np.stack((path[:-1], path[1:]), axis=1) for path in state.paths(16)]
    wanted = np.concatenate(paths)

    def equal() -> bool:
        drawn = page.lines(name)
        return drawn.shape == wanted.shape and bool(np.abs(drawn - wanted).max() < DRAWN)

    return wait_until(equal)


def state_at(angles: Any) -> MuscleState:
    """Return the state of the deltoid at angles, rad."""
    return SOLVER.solve(THESIS.rotation(angles))


def all_lines_are_seen(page: Page) -> bool:
    """Wait until the plots have room for all that is in them; return whether they had."""

    def room() -> bool:
        found = zip(page.plots(), page.plot_ranges(), strict=True)
        return all(
            (first, last) == (columns[0][0], columns[0][-1])
            and low < np.nanmin(columns[1:])
            and np.nanmax(columns[1:]) < high
            for columns, (first, last, low, high) in found
        )

    return wait_until(room)
