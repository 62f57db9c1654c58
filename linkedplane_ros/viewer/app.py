# SPDX-License-Identifier: Apache-2.0
"""The viewer: shows the newest states in the scene and the panels, once a frame."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import viser

from ..errors import LinkedPlaneError
from ..types import Floats
from .names import short_name
from .newest import MuscleInfo, Values, group_by_arm, match_coordinate
from .node import ViewerNode
from .panels.muscle import MusclePanel
from .panels.plots import Plots
from .panels.saving import Saving
from .panels.table import bands_table_html
from .scene.camera import Cameras, choose_view
from .scene.geometry import Markers, apply_message, drawables
from .scene.ground import pose_in_view, root_in_view
from .scene.look import Look, set_theme
from .scene.muscle import MuscleScene, light_scene
from .scene.rest import RestArms
from .scene.wire import read_markers

IDLE = 0.03  # s between frames without new messages
# s that new muscles wait for others before the panels are made: viser 1.1 applies a page's updates
# last, and one that is still loading has an error for each of a panel that is gone by then
SETTLED = 0.25
# HTML: what the library sends of a Markdown after it may reach a page when the text is gone
WAITING = (
    '<p style="margin: 1em">Waiting for a muscle: '
    '<code>ros2 run linkedplane_ros muscle_state_publisher</code></p>'
)


class Viewer:
    """Shows what a node reads.

    Everything runs in the thread of the library's event loop, as its objects must not be changed
    from two threads at once.
    """

    def __init__(self, server: viser.ViserServer, node: ViewerNode) -> None:
        """Prepare; nothing is shown before `run`."""
        self._server = server
        self._node = node
        self._scenes: dict[str, MuscleScene] = {}
        self._markers: dict[str, Markers] = {}  # those that have come
        self._rest = RestArms(node.fresh)
        self._muscles: dict[str, MuscleInfo] | None = None
        self._found: dict[str, MuscleInfo] = {}
        self._found_since = -math.inf
        self._panels: dict[str, MusclePanel] = {}
        self._colours: dict[str, Any] = {}
        self._cameras: Cameras | None = None
        self._look: Look | None = None
        self._plots: Plots | None = None
        self._saving: Saving | None = None
        self._answered: list[int] = []

    def _build_panels(self, muscles: dict[str, MuscleInfo]) -> None:
        """Build all panels again: a muscle is new or has changed."""
        if self._cameras is None:
            light_scene(self._server)
            self._cameras = Cameras(self._server)
        self._muscles = muscles
        self._panels = {}
        self._look = self._plots = self._saving = None
        gui = self._server.gui
        gui.reset()
        set_theme(gui, False)
        gui.set_panel_label('muscle viewer')
        gui.main_panel.dock_right()
        if not muscles:
            gui.add_html(WAITING)
            return
        names = short_names(muscles)
        first = next(iter(muscles.values()))
        arms = group_by_arm(muscles)
        tabs = gui.add_tab_group() if len(arms) > 1 else None
        for prefix, *others in arms:
            title = ', '.join(names[each] for each in (prefix, *others))
            info = muscles[prefix]
            with tabs.add_tab(title) if tabs else gui.add_folder(title):
                self._panels[prefix] = MusclePanel(
                    gui, info, self._make_mover(info), partial(self._find_coordinate, info, first)
                )
        look = Look(gui, first)
        pages = gui.add_tab_group()
        with pages.add_tab('plots'):
            labels = [
                ('' if len(names) == 1 else names[prefix], info) for prefix, info in muscles.items()
            ]
            self._plots = Plots(gui, labels)
        with pages.add_tab('look'):
            look.add_options(gui)
        with pages.add_tab('bands'):
            self._table = gui.add_html('')
        with pages.add_tab('save'):
            self._saving = Saving(self._server, gui, lambda: look.dark)
        self._look = look
        self._cameras.set_view(choose_view([info.side for info in muscles.values()]))
        for prefix, info in muscles.items():
            self._scenes[prefix].place_shoulder(info.side, len(names))
            root = short_name(info.skeleton.tree.root) if info.skeleton else ''
            self._scenes[prefix].mark_root(root, root_in_view(info))

    def _find_coordinate(self, info: MuscleInfo, first: MuscleInfo) -> int:
        """Return the number of a muscle's coordinate that a person has chosen; 0 if it has none."""
        chosen = self._look.coordinate if self._look else 0
        return match_coordinate(info, first, chosen) or 0

    def _make_mover(self, info: MuscleInfo) -> Callable[[Floats, Floats], bool]:
        return lambda angles, speeds: self._node.move_arm(info, angles, speeds)

    def run(self, going: Callable[[], bool]) -> None:
        """Draw whenever the node has something new, at least once a frame, as long as `going()`."""
        fresh, loop = self._node.fresh, self._server.get_event_loop()
        while going():
            fresh.wait(IDLE)
            fresh.clear()
            asyncio.run_coroutine_threadsafe(self._frame(time.monotonic()), loop).result()

    async def _frame(self, now: float) -> None:
        taken = {
            prefix: reader.newest.take_newest() for prefix, reader in self._node.readers.items()
        }
        muscles = {prefix: info for prefix, (info, _, _) in taken.items() if info is not None}
        for prefix in muscles:
            if prefix not in self._scenes:
                self._scenes[prefix] = MuscleScene(self._server, prefix)
        if muscles != self._found:
            self._found, self._found_since = muscles, now
        if muscles != self._muscles:
            if now - self._found_since < SETTLED:
                return
            self._build_panels(muscles)
        if self._look is None or self._plots is None or self._saving is None:
            return
        newest = {prefix: taken[prefix][1] for prefix in muscles}
        with self._server.atomic():
            for prefix, info in muscles.items():
                self._draw_muscle(prefix, info, newest[prefix], taken[prefix][2])
        if any(taken[prefix][2] for prefix in muscles):
            self._server.flush()
        watched = bool(self._server.get_clients())
        if not watched:
            self._node.mover.release()
        for prefix, panel in self._panels.items():
            panel.update(newest[prefix], watched)
        self._look.update_legend(next(iter(muscles.values())))
        answered = [values.answered for values in newest.values()]
        if answered != self._answered:
            self._answered = answered
            self._plots.add(now, list(newest.values()))
        if self._plots.draw(now, self._look.coordinate):
            self._table.content = ''.join(
                bands_table_html(
                    info,
                    newest[prefix],
                    self._find_coordinate(info, next(iter(muscles.values()))),
                    interfering_bands(self._markers.get(prefix, {})),
                )
                for prefix, info in muscles.items()
            )
        await self._saving.record_frame(now)

    def _draw_muscle(
        self, prefix: str, info: MuscleInfo, newest: Values, messages: list[bytes]
    ) -> None:
        """Update one muscle of the scene; before its first markers it is drawn at rest."""
        if self._look is None:
            return
        for message in messages:
            try:
                received = read_markers(message)
            except LinkedPlaneError as error:
                self._node.get_logger().warning(f'{prefix}/markers: {error}', once=True)
            else:
                apply_message(self._markers.setdefault(prefix, {}), received)
        self._scenes[prefix].pose_ground(pose_in_view(info, newest.angles))
        look, markers = self._look, self._markers.get(prefix)
        if markers is None:
            markers = self._rest.find_markers(prefix, info)
        hidden, colours = look.hidden, look.band_colours(look.band_values(prefix, info, newest))
        paint = None if colours is None else [each.tolist() for each in colours.values()]
        key = hidden, look.axes, id(markers), paint
        if messages or key != self._colours.get(prefix):
            self._colours[prefix] = key
            visible = {key: each for key, each in markers.items() if key[0] not in hidden}
            self._scenes[prefix].draw(drawables(visible, colours))
            self._scenes[prefix].show_axes(look.axes)


def interfering_bands(markers: Markers) -> set[int]:
    """Return the numbers of the bands that have an interference mark."""
    return {number for namespace, number in markers if namespace == 'interferences'}


def short_names(muscles: dict[str, MuscleInfo]) -> dict[str, str]:
    """Return a short name for each muscle: with its side if all differ, else its topic."""
    sides = [info.side for info in muscles.values()]
    if len(set(sides)) == len(sides):
        return {
            prefix: short_name(f'{info.side} {prefix.rpartition("/")[2]}')
            for prefix, info in muscles.items()
        }
    return {prefix: short_name(prefix[1:]) for prefix in muscles}
