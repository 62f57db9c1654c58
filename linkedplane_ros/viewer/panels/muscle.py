"""The panel of one muscle: sliders and buttons that move its arm, or follow its stream."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from ...types import Floats
from ..newest import Facts, Values
from .motions import Arm, poses, ranges

SETTLED = 0.15  # s without a move after which the arm is at rest
HEARTBEAT = 1.0  # s between joint states at rest: a node that comes back learns the pose from them
SHOWN = 0.05  # s between moves of the sliders by something else than a hand
SILENT = 3.0  # s without an answer after which a node that was told something is taken for dead
UNDECIDED = 1.5  # s in which other publishers are found, before the arm is moved or followed
STEP = 0.5  # deg

PLAY, STOP = 'play a sweep', 'stop'


class MusclePanel:
    """Moves one arm; `move` publishes angles (3,), rad, and speeds (3,), rad/s."""

    def __init__(
        self,
        gui: viser.GuiApi,
        facts: Facts,
        move: Callable[[Floats, Floats], None],
        coordinate: Callable[[], int],
    ) -> None:
        """Add the panel to what is open of the GUI; `coordinate` tells which one is swept."""
        self._move = move
        self._coordinate = coordinate
        self._ranges = np.round(np.degrees(ranges(facts.convention, facts.motion)), 1)
        self._poses = poses(facts.convention)
        self._arm = Arm()
        self._begun = time.monotonic()
        self._sent = self._shown = -np.inf
        self._heard = self._begun
        self._resting = False
        self._decided = False
        self._newest = Values()
        self._status = gui.add_html('')
        self._sliders = [
            gui.add_slider(f'{name} (deg)', float(low), float(high), STEP, float(max(low, 0.0)))
            for name, (low, high) in zip(facts.coordinates, self._ranges, strict=True)
        ]
        buttons = gui.add_button_group('go to', tuple(self._poses))
        self._play = gui.add_button(PLAY)
        self._follow = gui.add_checkbox('follow the stream', False)
        for slider in self._sliders:
            slider.on_update(self._dragged)
        buttons.on_click(self._go)
        self._play.on_click(self._sweep)
        self._follow.on_update(self._switched)

    # What the library calls is asynchronous, so that all is done in one thread, that of its loop.
    # It also calls for what is changed here, not in a browser; there is then no client.

    async def _dragged(self, event: Any) -> None:
        if event.client is None or self._follow.value:
            return
        now = time.monotonic()
        # a number that is being typed may be beyond the range for a moment
        low, high = self._ranges.T
        angles = np.radians(np.clip([slider.value for slider in self._sliders], low, high))
        self._send(self._arm.drag(angles, now), now)
        self._take_over()

    async def _go(self, event: Any) -> None:
        self._take_over()
        self._arm.glide(self._poses[event.target.value], time.monotonic())

    async def _sweep(self, _: Any) -> None:
        playing = self._play.label == STOP
        self._take_over()
        if not playing:
            k = self._coordinate()
            low, high = np.radians(self._ranges[k]).tolist()
            self._arm.sweep(k, low, high, time.monotonic())
            self._play.label = STOP

    async def _switched(self, event: Any) -> None:
        if event.client is not None:
            self._decide(self._follow.value)

    def _take_over(self) -> None:
        """Move the arm from here, from where it is."""
        self._arm.stop()
        self._play.label = PLAY
        self._resting = False
        if self._follow.value:
            self._decide(False)

    def _decide(self, follow: bool) -> None:
        """Follow the stream, or take over where the arm is."""
        self._decided = True
        self._arm.stop()
        self._play.label = PLAY
        if not follow and self._newest.angles is not None:
            self._arm.angles = self._newest.angles
        self._follow.value = follow
        for slider in self._sliders:
            slider.disabled = follow

    def _send(self, speeds: Floats, now: float) -> None:
        self._move(self._arm.angles, speeds)
        self._sent = now

    def tick(self, newest: Values) -> None:
        """Go on: to be called for each frame, with the newest state."""
        now = time.monotonic()
        if newest.answered != self._newest.answered:
            self._heard = now
        self._newest = newest
        silent = self._sent > self._heard and now > self._heard + SILENT
        self._status.content = status(newest, self._follow.value, silent)
        if not self._decided:
            if now < self._begun + UNDECIDED and not newest.rivals:
                return
            self._decided = True
            if newest.rivals:
                self._decide(True)
        if self._follow.value:
            if newest.angles is not None:
                self._show(newest.angles, now)
        elif self._arm.moving:
            self._send(self._arm.at(now), now)
            self._resting = False
            self._show(self._arm.angles, now, last=not self._arm.moving)
        elif now > self._sent + (HEARTBEAT if self._resting else SETTLED):
            self._send(np.zeros(3), now)
            self._resting = True

    def _show(self, angles: Floats, now: float, last: bool = False) -> None:
        """Let the sliders go along."""
        if now < self._shown + SHOWN and not last:
            return
        self._shown = now
        low, high = self._ranges.T
        shown = np.clip(np.round(np.degrees(angles), 1), low, high).tolist()
        for slider, value in zip(self._sliders, shown, strict=True):
            slider.value = value


def status(newest: Values, following: bool, silent: bool) -> str:
    """Return a line on what is to be known of the node, or nothing, as HTML."""
    line = ''
    if not newest.present:
        line = 'the node is gone: its last state stays'
    elif newest.lengths is None:
        line = 'no joint state has been answered so far'
    elif silent and not following:
        line = 'the node does not answer: its last state stays'
    elif newest.rivals and not following:
        line = 'something else moves this arm, too: follow the stream?'
    return (
        f'<div style="padding:0 0.9em;font-size:0.8em;color:#c4622d">{line}</div>' if line else ''
    )
