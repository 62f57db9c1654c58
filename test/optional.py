# SPDX-License-Identifier: Apache-2.0
"""Marks for tests that need a library which may not be installed.

A module-level `pytest.importorskip` would hide its whole module, and with ROS's launch_testing
plugin the whole collection. So every test module is imported without these libraries, and the
tests that need one are marked.
"""

from __future__ import annotations

from importlib.util import find_spec

import pytest


def is_installed(module: str) -> bool:
    """Return whether a module can be found, without importing it."""
    try:
        return find_spec(module) is not None
    except (ImportError, ValueError):
        return False


def requires(*modules: str) -> pytest.MarkDecorator:
    """Return a mark that skips a test unless all of these modules are installed."""
    missing = [module for module in modules if not is_installed(module)]
    return pytest.mark.skipif(bool(missing), reason=f'not installed: {", ".join(missing)}')
