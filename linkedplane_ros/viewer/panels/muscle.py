# SPDX-License-Identifier: Apache-2.0
"""The panel of one muscle: sliders and buttons that move its arm, or follow other publishers."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from html import escape
from typing import Any

import numpy as np
import viser

from ...types import Floats
from ..names import distinct_names
from ..newest import MuscleInfo, Values
from .motions import Arm, end_poses
from .ranges import rest_pose, rounded_ranges

SETTLED = 0.15  # s without a move after which the arm is at rest
HEARTBEAT = 1.0  # s between joint states at rest: a restarted node learns the pose from them
SHOWN = 0.05  # s between moves of the sliders by the program
SILENT = 3.0  # s without an answer, after which the node is reported as silent
ALERT = 1.5  # s to find other publishers, before anything is published
STEP = 0.5  # deg or mm

PLAY, STOP = 'play a sweep', 'stop'


class MusclePanel:
    """The controls of one arm.

    Parameters
    ----------
    gui
        Its open part gets the controls.
    info
        The muscle's.
    move
        Publishes coordinates (d,) and speeds (d,), in rad or m and s, and returns whether it did.
    coordinate
        Returns the number of the coordinate that is swept.

    """

    def __init__(
        self,
        gui: viser.GuiApi,
        info: MuscleInfo,
        move: Callable[[Floats, Floats], bool],
        coordinate: Callable[[], int],
    ) -> None:
        self._move = move
        self._coordinate = coordinate
        rest = rest_pose(info)
        self._units = np.array([unit.size for unit in info.units])
        self._ranges = rounded_ranges(info)
        self._poses = {'neutral': rest}
        if info.skeleton is None and not info.obstacle:
            self._poses = end_poses(info.convention)
        self._arm = Arm(rest)
        self._never = info.obstacle
        self._begun = time.monotonic()
        self._sent = self._shown = -np.inf
        self._heard = self._begun
        self._asked = self._resting = False  # whether a person has moved it, and let go
        self._newest = Values()
        self._obstacle = ''
        self._status = gui.add_html('')
        self._sliders = []
        labels = map('{0} ({1.name})'.format, distinct_names(info.coordinates), info.units)
        for label, (low, high), start in zip(
            labels, self._ranges.tolist(), rest / self._units, strict=True
        ):
            fixed = low == high  # the library's sliders cannot be so
            slider = gui.add_slider(
                label,
                low,
                high + STEP if fixed else high,
                STEP if fixed else min(STEP, high - low),
                min(max(float(start), low), high),
                disabled=fixed,
            )
            self._sliders.append(slider)
        self._go_to = gui.add_button_group('go to', tuple(self._poses))
        self._play = gui.add_button(PLAY)
        self._follow = gui.add_checkbox('follow the stream', False)
        for slider in self._sliders:
            slider.on_update(self._on_drag)
        self._go_to.on_click(self._on_go_to)
        self._play.on_click(self._on_sweep)
        self._follow.on_update(self._on_follow)

    # The library's callbacks are asynchronous: all of them run in one thread, that of its loop.
    # They are also called for changes that are made here; there is then no client.

    async def _on_drag(self, event: Any) -> None:
        if event.client is None or self._follow.value:
            return
        now = time.monotonic()
        shown = np.array([slider.value for slider in self._sliders])
        speeds = self._arm.drag(self._units * shown, now)
        self._take_over()
        self._send(speeds, now)

    async def _on_go_to(self, event: Any) -> None:
        if self._obstacle:
            return
        self._take_over()
        self._arm.glide(self._poses[event.target.value], time.monotonic())

    async def _on_sweep(self, _: Any) -> None:
        if self._obstacle:
            return
        playing = self._play.label == STOP
        self._take_over()
        if not playing:
            k = self._coordinate()
            low, high = (self._units[k] * self._ranges[k]).tolist()
            self._arm.sweep(k, low, high, time.monotonic())
            self._play.label = STOP

    async def _on_follow(self, event: Any) -> None:
        if event.client is not None:
            self._set_following(self._follow.value)

    def _take_over(self) -> None:
        """Move the arm from here on, starting where it is: a person has asked for it."""
        if self._follow.value:
            self._set_following(False)
        self._stop()
        self._asked = True

    def _stop(self) -> None:
        """End any motion."""
        self._arm.stop()
        self._play.label = PLAY
        self._resting = False

    def _set_following(self, follow: bool) -> None:
        """Leave the arm to others; or let a person move it."""
        self._stop()
        self._asked = False
        self._follow.value = follow
        for slider, (low, high) in zip(self._sliders, self._ranges, strict=True):
            slider.disabled = follow or low == high

    def _set_obstacle(self, obstacle: str) -> None:
        """Stop where the arm is not to be moved from here, and say so."""
        if self._obstacle == obstacle:
            return
        self._obstacle = obstacle
        if obstacle:
            self._set_following(True)
        self._play.disabled = self._follow.disabled = bool(obstacle)
        self._go_to.visible = not obstacle  # the library cannot disable it

    def _send(self, speeds: Floats, now: float) -> None:
        if now > self._begun + ALERT and self._move(self._arm.angles, speeds):
            self._sent = now

    def update(self, newest: Values, watched: bool) -> None:
        """Continue motions and show the newest state; called for each frame.

        Parameters
        ----------
        newest
            The muscle's.
        watched
            Whether a browser looks on; without one nothing is moved.

        """
        now = time.monotonic()
        if newest.answered != self._newest.answered:
            self._heard = now
        self._newest = newest
        self._set_obstacle(newest.obstacle or self._never)
        if self._asked and not watched:
            self._stop()
            self._asked = False
        silent = self._sent > self._heard and now > self._heard + SILENT
        self._status.content = status_html(
            replace(newest, obstacle=self._obstacle), self._follow.value, silent
        )
        if not self._asked:
            if newest.angles is not None:
                self._arm.angles = newest.angles
                self._move_sliders(newest.angles, now)
        elif self._arm.is_moving:
            self._send(self._arm.advance(now), now)
            self._resting = False
            self._move_sliders(self._arm.angles, now, last=not self._arm.is_moving)
        elif now > self._sent + (HEARTBEAT if self._resting else SETTLED):
            self._send(np.zeros_like(self._arm.angles), now)
            self._resting = self._sent == now

    def _move_sliders(self, angles: Floats, now: float, last: bool = False) -> None:
        """Move the sliders to coordinates (d,) some times a second; `last` ones in any case."""
        if now < self._shown + SHOWN and not last:
            return
        self._shown = now
        low, high = self._ranges.T
        shown = np.clip(np.round(angles / self._units, 1), low, high).tolist()
        for slider, value in zip(self._sliders, shown, strict=True):
            slider.value = value


def status_html(newest: Values, following: bool, silent: bool) -> str:
    """Return a line if something is wrong with the node or its input, as HTML."""
    line = newest.obstacle
    if not newest.present:
        line = 'the node has stopped; its last state is shown'
    elif line:
        pass
    elif newest.lengths is None:
        line = 'nothing moves this arm yet: move a slider, or press a button'
    elif silent and not following:
        line = 'the node does not answer; its last state is shown'
    elif newest.rivals and not following:
        line = 'another publisher moves this arm, too: follow the stream?'
    style = 'padding:0 0.9em;font-size:0.8em;color:#c4622d;overflow-wrap:anywhere'
    return f'<div style="{style}">{escape(line)}</div>' if line else ''
