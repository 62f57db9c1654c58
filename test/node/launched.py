# SPDX-License-Identifier: Apache-2.0
"""What the launch files start, as seen through the stand-ins of launch."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from launch_stand_ins import ExecuteProcess, Node, list_started

from linkedplane_ros.node.parameters import SPECS
from linkedplane_ros.node.settings import Settings

TOP = Path(__file__).parents[2]
DELTOID = TOP / 'launch' / 'deltoid.launch.py'
BOTH = TOP / 'launch' / 'both_shoulders.launch.py'
FILES = sorted((TOP / 'launch').glob('*.launch.py'))
DEFAULTS = {spec.name: spec.default for spec in SPECS}


def nodes(path: Path, executable: str, **arguments: Any) -> list[Node]:
    """Return the nodes of an executable that a launch file starts."""
    found = [action for action in list_started(path, **arguments) if isinstance(action, Node)]
    return [node for node in found if node.executable == executable]


def settings(node: Node) -> Settings:
    """Return the settings that a node's parameters make; launch_ros keeps a value's type."""
    values = dict(DEFAULTS)
    for given in node.parameters:
        assert isinstance(given, dict)
        values |= given
    assert values.pop('use_sim_time', False) in (True, False)
    assert set(values) == set(DEFAULTS)
    return Settings.from_values(values)


def played(path: Path, **arguments: Any) -> list[str]:
    """Return the command that plays the recording."""
    [player] = [a for a in list_started(path, **arguments) if isinstance(a, ExecuteProcess)]
    return player.cmd
