# SPDX-License-Identifier: Apache-2.0
"""The controls of the look: what colours the bands, their legend, and what else is visible."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import viser

from ...drawing.colours import head_colour
from ...drawing.units import MILLIMETRES
from ...types import Floats
from ..names import distinct_names, html_name
from ..newest import MuscleInfo, Values, match_coordinate
from .colour_map import css_colour, legend_html, map_colours, round_up

HEAD, LENGTH, ARM = 'head', 'length change', 'moment arm'
HIDEABLE = {
    'obstacle spheres': ('obstacle_spheres', False),
    'interference spheres': ('interference_spheres', False),
    'interfering bands': ('interferences', True),
    'band planes': ('planes', False),
    'bones': ('bones', True),
}


class Look:
    """What the user has chosen; every browser shows the same."""

    def __init__(self, gui: viser.GuiApi, info: MuscleInfo) -> None:
        """Add the controls that are always visible to the open part of the GUI."""
        self._gui = gui
        self._first = info
        self._limit = 0.0
        self._legend_key: tuple[Any, ...] = ()
        self._references: dict[str, Floats] = {}
        self._bands_by = gui.add_dropdown('colour by', (HEAD, LENGTH, ARM))
        self._coordinate = gui.add_dropdown('coordinate', distinct_names(info.coordinates))
        self._legend = gui.add_html('')
        self._bands_by.on_update(self._reset_scale)
        self._coordinate.on_update(self._reset_scale)

    def add_options(self, gui: viser.GuiApi) -> None:
        """Add the other controls to the open part of the GUI."""
        self._boxes = {
            namespace: gui.add_checkbox(text, shown)
            for text, (namespace, shown) in HIDEABLE.items()
        }
        self._axes = gui.add_checkbox('axes', True)
        self._dark = gui.add_checkbox('dark', False)
        again = gui.add_button(
            'zero the length change', hint='Length changes count from the present pose.'
        )
        again.on_click(self._reset_references)
        self._dark.on_update(self._update_theme)

    async def _reset_scale(self, _: Any) -> None:
        self._limit = 0.0

    async def _reset_references(self, _: Any) -> None:
        self._references.clear()

    async def _update_theme(self, _: Any) -> None:
        set_theme(self._gui, self._dark.value)

    @property
    def coordinate(self) -> int:
        """The number of the chosen coordinate, among those of the first muscle."""
        return int(self._coordinate.options.index(self._coordinate.value))

    @property
    def hidden(self) -> set[str]:
        """The namespaces that are hidden."""
        return {namespace for namespace, box in self._boxes.items() if not box.value}

    @property
    def axes(self) -> bool:
        """Whether the axes are visible."""
        return bool(self._axes.value)

    @property
    def dark(self) -> bool:
        """Whether the page is dark."""
        return bool(self._dark.value)

    def band_values(self, prefix: str, info: MuscleInfo, newest: Values) -> Floats | None:
        """Return the values (n,), mm, that colour the bands of a muscle; None: by their heads.

        A length change counts from the first state that was seen, or from the button.
        """
        by = self._bands_by.value
        if by == LENGTH and newest.lengths is not None:
            reference = self._references.setdefault(prefix, newest.lengths)
            if len(reference) != len(newest.lengths):
                reference = self._references[prefix] = newest.lengths
            return np.asarray(MILLIMETRES * (newest.lengths - reference))
        k = match_coordinate(info, self._first, self.coordinate)
        if by == ARM and newest.arms is not None and k is not None and k < newest.arms.shape[1]:
            return np.asarray(MILLIMETRES * newest.arms[:, k])
        return None

    def band_colours(self, values: Floats | None) -> dict[int, npt.NDArray[np.uint8]] | None:
        """Return the colour of each band; widens the map if a value is beyond its end."""
        if values is None:
            return None
        self._limit = max(self._limit, round_up(float(np.abs(values).max(initial=1.0))))
        return dict(enumerate(map_colours(values, self._limit)))

    def update_legend(self, info: MuscleInfo) -> None:
        """Show what the colours mean."""
        by, name = self._bands_by.value, self._coordinate.value
        key = by, name, self._limit, info.heads
        if key == self._legend_key:
            return
        self._legend_key = key
        if by == HEAD:
            self._legend.content = heads_legend_html([head for head, _ in info.heads])
        else:
            title = 'length change' if by == LENGTH else f'moment arm about {html_name(name)}'
            self._legend.content = legend_html(title, self._limit or 1.0, 'mm')


def set_theme(gui: viser.GuiApi, dark: bool) -> None:
    """Make the page dark or light."""
    gui.configure_theme(
        dark_mode=dark, show_logo=False, show_share_button=False, control_width='medium'
    )


def heads_legend_html(heads: list[str]) -> str:
    """Return the names of the heads beside their colours, as HTML."""
    items = []
    for i, head in enumerate(heads):
        chip = (
            f'background:{css_colour(head_colour(i))};display:inline-block;width:1em;height:0.7em'
        )
        items.append(
            f'<span style="margin-right:0.9em"><i style="{chip}"></i> {html_name(head)}</span>'
        )
    return f'<div style="padding:0 0.9em 0.6em;font-size:0.8em">{"".join(items)}</div>'
