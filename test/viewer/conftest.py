# SPDX-License-Identifier: Apache-2.0
"""The viewer in a browser."""

from __future__ import annotations

from collections.abc import Iterator
from urllib.parse import urlsplit

import pytest
from browser import open_browser
from viewer_stage import Stage


@pytest.fixture(scope='module')
def stage(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stage]:
    """Run the node, the viewer and a page once, for all tests of a file.

    At the end the page must have had no error, and asked for nothing beyond this machine.
    """
    folder = tmp_path_factory.mktemp('viewer')
    with open_browser() as chromium:
        made = Stage(folder, chromium)
        yield made
        assert made.page.errors == []
        hosts = {urlsplit(url).hostname for url in made.page.requests}
        assert '127.0.0.1' in hosts
        assert hosts <= {'127.0.0.1', None}  # None: a blob of the page's own
        assert made.viewer.stop() == 0, made.viewer.text
        assert made.node.stop() == 0
    assert 'Traceback' not in made.viewer.text
