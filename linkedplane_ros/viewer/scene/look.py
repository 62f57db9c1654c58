"""How the muscles are shown: what bands are coloured by, the legend, what else is to be seen."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import viser

from ...drawing.colours import HEAD_COLOURS
from ...types import Floats
from ..newest import Facts, Values
from .colour_map import colours, legend, round_up

HEAD, LENGTH, ARM = 'head', 'length change', 'moment arm'
MILLIMETRES = 1e3
HIDEABLE = {
    'obstacle spheres': ('obstacle_spheres', False),
    'interference spheres': ('interference_spheres', False),
    'interfering bands': ('interferences', True),
    'band planes': ('planes', False),
    'bones': ('bones', True),
}


class Look:
    """The choices; every browser sees the same."""

    def __init__(self, gui: viser.GuiApi, facts: Facts) -> None:
        """Add what is always at hand to what is open of the GUI."""
        self._gui = gui
        self._most = 0.0
        self._shown: tuple[Any, ...] = ()
        self._references: dict[str, Floats] = {}
        self._bands_by = gui.add_dropdown('colour by', (HEAD, LENGTH, ARM))
        self._coordinate = gui.add_dropdown('coordinate', facts.coordinates)
        self._legend = gui.add_html('')
        self._bands_by.on_update(self._begin_anew)
        self._coordinate.on_update(self._begin_anew)

    def add_more(self, gui: viser.GuiApi) -> None:
        """Add the rest to what is open of the GUI."""
        self._boxes = {
            namespace: gui.add_checkbox(text, shown)
            for text, (namespace, shown) in HIDEABLE.items()
        }
        self._axes = gui.add_checkbox('axes', True)
        self._dark = gui.add_checkbox('dark', False)
        again = gui.add_button(
            'no length change here', hint='Length changes count from this pose on.'
        )
        again.on_click(self._measure_anew)
        self._dark.on_update(self._darken)

    async def _begin_anew(self, _: Any) -> None:
        self._most = 0.0

    async def _measure_anew(self, _: Any) -> None:
        self._references.clear()

    async def _darken(self, _: Any) -> None:
        theme(self._gui, self._dark.value)

    @property
    def coordinate(self) -> int:
        """Which coordinate is looked at: 0, 1 or 2."""
        return int(self._coordinate.options.index(self._coordinate.value))

    @property
    def hidden(self) -> set[str]:
        """The namespaces that are not to be seen."""
        return {namespace for namespace, box in self._boxes.items() if not box.value}

    @property
    def axes(self) -> bool:
        """Whether the axes are to be seen."""
        return bool(self._axes.value)

    @property
    def dark(self) -> bool:
        """Whether the page is dark."""
        return bool(self._dark.value)

    def measured(self, prefix: str, newest: Values) -> Floats | None:
        """Return what the bands of a muscle are coloured by (n,), mm; None: by their heads.

        The length change is that since the first state that was seen, or since the button.
        """
        by = self._bands_by.value
        if by == LENGTH and newest.lengths is not None:
            reference = self._references.setdefault(prefix, newest.lengths)
            if len(reference) != len(newest.lengths):
                reference = self._references[prefix] = newest.lengths
            return np.asarray(MILLIMETRES * (newest.lengths - reference))
        if by == ARM and newest.arms is not None:
            return np.asarray(MILLIMETRES * newest.arms[:, self.coordinate])
        return None

    def band_colours(self, values: Floats | None) -> dict[int, npt.NDArray[np.uint8]] | None:
        """Return the colour of each band, and widen the map where a value is beyond its end."""
        if values is None:
            return None
        self._most = max(self._most, round_up(float(np.abs(values).max(initial=1.0))))
        return dict(enumerate(colours(values, self._most)))

    def write_legend(self, facts: Facts) -> None:
        """Say what the colours mean."""
        by, name = self._bands_by.value, self._coordinate.value
        shown = by, name, self._most, facts.heads
        if shown == self._shown:
            return
        self._shown = shown
        if by == HEAD:
            self._legend.content = legend_of_heads([head for head, _ in facts.heads])
        else:
            title = 'length change' if by == LENGTH else f'moment arm about {name}'
            self._legend.content = legend(title, self._most or 1.0, 'mm')


def theme(gui: viser.GuiApi, dark: bool) -> None:
    """Make the page dark or light."""
    gui.configure_theme(
        dark_mode=dark, show_logo=False, show_share_button=False, control_width='medium'
    )


def legend_of_heads(heads: list[str]) -> str:
    """Return the heads' names beside their colours as a piece of HTML."""
    items = []
    for i, head in enumerate(heads):
        colour = ','.join(str(round(255 * c)) for c in HEAD_COLOURS[i % len(HEAD_COLOURS)])
        chip = f'background:rgb({colour});display:inline-block;width:1em;height:0.7em'
        items.append(f'<span style="margin-right:0.9em"><i style="{chip}"></i> {head}</span>')
    return f'<div style="padding:0 0.9em 0.6em;font-size:0.8em">{"".join(items)}</div>'
