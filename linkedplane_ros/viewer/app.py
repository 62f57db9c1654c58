"""The viewer: takes the newest states and keeps scene, panels and plots in step with them."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Any

import viser

from ..types import Floats
from .newest import Facts, Values
from .node import ViewerNode
from .panels.muscle import MusclePanel
from .panels.plots import Plots
from .panels.saving import Saving
from .panels.table import table
from .scene.camera import Cameras, view
from .scene.geometry import Markers, apply, drawables
from .scene.look import Look, theme
from .scene.muscle import MuscleScene, prepare
from .scene.wire import markers

IDLE = 0.03  # s between frames in which nothing has come
WAITING = 'Waiting for a muscle: `ros2 run linkedplane_ros muscle_state_publisher`'


class Viewer:
    """All that is shown of what a node reads.

    Everything is done in the thread of the library's event loop: its objects are not to be
    changed from two threads at once.
    """

    def __init__(self, server: viser.ViserServer, node: ViewerNode) -> None:
        """Nothing is shown before `run`."""
        self._server = server
        self._node = node
        self._scenes: dict[str, MuscleScene] = {}
        self._markers: dict[str, Markers] = {}
        self._facts: dict[str, Facts] | None = None
        self._panels: dict[str, MusclePanel] = {}
        self._colours: dict[str, Any] = {}
        self._cameras: Cameras | None = None
        self._look: Look | None = None
        self._plots: Plots | None = None
        self._saving: Saving | None = None
        self._answered: list[int] = []

    def _build(self, muscles: dict[str, Facts]) -> None:
        """Make the panels anew: a muscle has come, or has become another."""
        if self._cameras is None:
            prepare(self._server)
            self._cameras = Cameras(self._server)
        self._facts = muscles
        self._panels = {}
        self._look = self._plots = self._saving = None
        gui = self._server.gui
        gui.reset()
        theme(gui, False)
        gui.set_panel_label('muscle viewer')
        gui.main_panel.dock_right()
        if not muscles:
            gui.add_markdown(WAITING)
            return
        names = names_of(muscles)
        first = next(iter(muscles.values()))
        tabs = gui.add_tab_group() if len(names) > 1 else None
        for prefix, facts in muscles.items():
            place = tabs.add_tab(names[prefix]) if tabs else gui.add_folder(names[prefix])
            with place:
                self._panels[prefix] = MusclePanel(
                    gui, facts, self._mover(prefix, facts), lambda: self._coordinate
                )
        look = Look(gui, first)
        pages = gui.add_tab_group()
        with pages.add_tab('plots'):
            labels = [
                ('' if len(names) == 1 else names[prefix], f) for prefix, f in muscles.items()
            ]
            self._plots = Plots(gui, labels)
        with pages.add_tab('look'):
            look.add_more(gui)
        with pages.add_tab('bands'):
            self._table = gui.add_html('')
        with pages.add_tab('save'):
            self._saving = Saving(self._server, gui, lambda: look.dark)
        self._look = look
        self._cameras.look(view([facts.side for facts in muscles.values()]))
        for prefix, facts in muscles.items():
            self._scenes[prefix].settle(facts.side, len(names))

    @property
    def _coordinate(self) -> int:
        return self._look.coordinate if self._look else 0

    def _mover(self, prefix: str, facts: Facts) -> Callable[[Floats, Floats], None]:
        return lambda angles, speeds: self._node.move(prefix, facts, angles, speeds)

    def run(self, going: Callable[[], bool]) -> None:
        """Draw as long as it is going: whenever the node has something new, once a frame."""
        fresh, loop = self._node.fresh, self._server.get_event_loop()
        while going():
            fresh.wait(IDLE)
            fresh.clear()
            asyncio.run_coroutine_threadsafe(self._frame(time.monotonic()), loop).result()

    async def _frame(self, now: float) -> None:
        taken = {prefix: reader.newest.take() for prefix, reader in self._node.readers.items()}
        facts = {prefix: each for prefix, (each, _, _) in taken.items() if each is not None}
        for prefix in facts:
            if prefix not in self._scenes:
                self._scenes[prefix] = MuscleScene(self._server, prefix)
        if facts != self._facts:
            self._build(facts)
        if self._look is None or self._plots is None or self._saving is None:
            return
        newest = {prefix: taken[prefix][1] for prefix in facts}
        with self._server.atomic():
            for prefix in facts:
                self._draw(prefix, newest[prefix], taken[prefix][2])
        if any(taken[prefix][2] for prefix in facts):
            self._server.flush()
        for prefix in facts:
            self._panels[prefix].tick(newest[prefix])
        self._look.write_legend(next(iter(facts.values())))
        answered = [values.answered for values in newest.values()]
        if answered != self._answered:
            self._answered = answered
            self._plots.add(now, list(newest.values()))
        if self._plots.draw(now, self._look.coordinate):
            self._table.content = ''.join(
                table(f, newest[p], self._look.coordinate, interfering(self._markers.get(p, {})))
                for p, f in facts.items()
            )
        await self._saving.frame(now)

    def _draw(self, prefix: str, newest: Values, messages: list[bytes]) -> None:
        """Bring one muscle of the scene up to date."""
        if self._look is None:
            return
        there = self._markers.setdefault(prefix, {})
        for message in messages:
            try:
                apply(there, markers(message))
            except ValueError as error:
                self._node.get_logger().warning(f'{prefix}/markers: {error}', once=True)
        look = self._look
        hidden, colours = look.hidden, look.band_colours(look.measured(prefix, newest))
        key = hidden, look.axes, None if colours is None else [c.tolist() for c in colours.values()]
        if messages or key != self._colours.get(prefix):
            self._colours[prefix] = key
            seen = {at: each for at, each in there.items() if at[0] not in hidden}
            self._scenes[prefix].draw(drawables(seen, colours))
            self._scenes[prefix].show_axes(look.axes)


def interfering(there: Markers) -> set[int]:
    """Return the bands that are marked as interfering."""
    return {number for namespace, number in there if namespace == 'interferences'}


def names_of(muscles: dict[str, Facts]) -> dict[str, str]:
    """Return a short name for each muscle: its side where that tells them apart, or its topic."""
    sides = [facts.side for facts in muscles.values()]
    if len(set(sides)) == len(sides):
        return {p: f'{f.side} {p.rpartition("/")[2]}' for p, f in muscles.items()}
    return {prefix: prefix[1:] for prefix in muscles}
