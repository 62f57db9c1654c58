"""What the documents and configuration files say is what the code does."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from linkedplane_ros import JOINT_CONVENTIONS
from linkedplane_ros.parameters import SPECS, markdown

TOP = Path(__file__).parent.parent
README = (TOP / 'README.md').read_text()


def test_the_readme_has_the_table_of_the_parameters() -> None:
    table = README.partition('<!-- parameters -->\n')[2].partition('\n<!-- /parameters -->')[0]
    assert table == markdown()


@pytest.mark.parametrize('name', JOINT_CONVENTIONS)
def test_the_readme_has_every_convention_with_its_coordinates(name: str) -> None:
    row = next(line for line in README.splitlines() if line.startswith(f'| `{name}`'))
    assert ', '.join(JOINT_CONVENTIONS[name].coordinates) in row


def flat(tree: dict, prefix: str = '') -> dict:
    """Return a tree of parameters by their dotted names."""
    found = {}
    for key, value in tree.items():
        name = f'{prefix}{key}'
        found.update(flat(value, f'{name}.') if isinstance(value, dict) else {name: value})
    return found


def test_the_parameter_file_has_the_defaults() -> None:
    file = yaml.safe_load((TOP / 'config' / 'params.yaml').read_text())
    given = flat(file['/**/muscle_state_publisher']['ros__parameters'])
    assert given == {spec.name: spec.default for spec in SPECS if spec.name != 'joint_names'}


def test_rviz_is_set_to_the_topic_and_frame_of_the_node() -> None:
    rviz = yaml.safe_load((TOP / 'config' / 'deltoid.rviz').read_text())['Visualization Manager']
    display = next(d for d in rviz['Displays'] if d['Class'].endswith('/MarkerArray'))
    assert display['Topic']['Value'] == '/deltoid/markers'
    assert set(display['Namespaces']) == {'attachments', 'bands', 'bones', 'obstacle_spheres'}
    assert rviz['Global Options']['Fixed Frame'] == 'scapula'
