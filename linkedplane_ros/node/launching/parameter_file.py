# SPDX-License-Identifier: Apache-2.0
"""What a ROS file of parameters says for one node."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ...errors import LinkedPlaneError
from ...files import read_small_text
from ...muscle.yaml_mapping import load_yaml

SECTION = 'ros__parameters'


def read_parameter_file(path: Path, node: str) -> dict[str, Any]:
    """Return the parameters that a file sets for a node.

    Parameters
    ----------
    path
        The file.
    node
        The node's full name. What is said for it by this name wins over what wildcards say.

    Raises
    ------
    LinkedPlaneError
        If the file cannot be read.

    """
    try:
        content = load_yaml(read_small_text(path, LinkedPlaneError))
    except LinkedPlaneError as error:
        where = '' if str(path) in str(error) else f'{path}: '
        raise LinkedPlaneError(f'params_file: {where}{error}') from None
    found = [section for section in list_sections(content) if matches(section[0], node)]
    parameters: dict[str, Any] = {}
    for _, given in sorted(found, key=lambda section: section[0] == node):
        parameters |= given
    return parameters


def list_sections(content: Any, name: str = '') -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the parameters of each node in a file, with its name, in which there may be wildcards.

    Namespaces may be nested: `left: {muscle_state_publisher: {ros__parameters: ...}}`.
    """
    if isinstance(content, Mapping):
        for key, value in content.items():
            if key == SECTION and isinstance(value, Mapping):
                yield name, value
            else:
                yield from list_sections(value, f'{name}/{str(key).strip("/")}')


def matches(pattern: str, node: str) -> bool:
    """Return whether a name with wildcards means a node: * is one part of a name, ** are any."""
    expression = re.escape(pattern).replace(r'/\*\*', '(/[^/]+)*').replace(r'\*', '[^/]+')
    return re.fullmatch(expression, node) is not None
