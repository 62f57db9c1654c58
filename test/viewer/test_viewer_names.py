# SPDX-License-Identifier: Apache-2.0
"""The viewer in a browser: names that are HTML are shown as text, wherever they come from."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from browser import WINDOW, Page, open_browser, wait_until
from viewer_stage import MISSING, ViewerProcess

from linkedplane_ros import BroadMuscle

pytestmark = [pytest.mark.skipif(bool(MISSING), reason=MISSING), pytest.mark.browser]
SCRIPTS = (
    '<img src=x onerror=hit=1>',
    '<svg onload=hit=2>',
    '"><b onclick=hit=3>b</b>',
    '[a](javascript:hit=4)',
    '{{7*7}}${hit=5}',
)
FOUND = """() => ({
  hit: window.hit ?? null,
  made: [...document.querySelectorAll('*')].filter(each =>
    each.getAttribute('src') === 'x' || ['onerror', 'onload', 'onclick'].some(
      name => each.hasAttribute(name)) || /^javascript:/.test(each.href ?? '')).length,
})"""


def write_model(path: Path) -> BroadMuscle:
    """Write the deltoid with scripts in place of the names of its bands and heads."""
    muscle = BroadMuscle.load('deltoid')
    names = [SCRIPTS[i] if i < len(SCRIPTS) else name for i, name in enumerate(muscle.band_names)]
    new: dict[str, str] = dict(zip(muscle.band_names, names, strict=True))
    heads = tuple(
        replace(
            head,
            name=SCRIPTS[k],
            bands=tuple(new[band] for band in head.bands),
            represented_by=new[head.represented_by],
        )
        for k, head in enumerate(muscle.heads)
    )
    evil = replace(muscle, band_names=tuple(names), heads=heads)
    evil.to_yaml(path)
    return evil


def test_names_of_bands_heads_and_joints_are_text_in_panel_plots_and_table(tmp_path: Path) -> None:
    model = tmp_path / 'deltoid.yaml'
    evil = write_model(model)
    viewer = ViewerProcess(
        tmp_path / 'viewer.log', '--node', '--ros-args', '-p', f'muscle:={model}'
    )
    with viewer, open_browser() as chromium:
        page = Page(chromium.new_page(viewport=WINDOW), viewer.url)
        dialogs: list[Any] = []
        page.page.on('dialog', lambda each: dialogs.append(each))
        page.press_button('flexion 80')
        page.press_button('neutral')
        assert wait_until(lambda: len(page.plots()) == 2)
        for head in evil.heads:  # the legend
            assert wait_until(lambda head=head: page.page.get_by_text(head.name).count() > 0)
        for label in page.page.evaluate(
            'Object.values(window.__viserTestpoints.uplots)[0].chart.series.map(s => s.label)'
        )[1:]:
            assert label in SCRIPTS
        # the library's own plot would have a legend and a title of them
        for plot in page.page.locator('.uplot').all():
            plot.hover(force=True)
        page.open_tab('bands')
        for band in evil.band_names:
            assert wait_until(
                lambda band=band: page.page.get_by_role('cell', name=band, exact=True).count() > 0
            )
        page.open_tab('plots')
        page.choose_option('head', 'moment arm')
        page.choose_option('time', 'coordinate')
        page.hover_slider(0, 40.0)
        page.page.wait_for_timeout(500.0)
        assert page.page.evaluate(FOUND) == {'hit': None, 'made': 0}
        assert dialogs == []
        assert not any(url.endswith('/x') for url in page.requests)
        assert page.errors == []
