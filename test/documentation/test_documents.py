# SPDX-License-Identifier: Apache-2.0
"""What the configuration files say is what the code does."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
import yaml
from builtin_interfaces.msg import Time
from ros_harness import Peer, together

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.joints.conventions import THESIS_CONVENTION
from linkedplane_ros.node.markers import MuscleMarkers
from linkedplane_ros.node.messages import Answers
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.node.parameters import SPECS
from linkedplane_ros.node.topics import OUTPUTS

TOP = Path(__file__).parents[2]


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
    # a list of names has no default that a file could have: it stands there as a comment
    assert given == {spec.name: spec.default for spec in SPECS if spec.default != ['']}


NAMESPACES = {
    'attachments',
    'bands',
    'bones',
    'interference_spheres',
    'interferences',
    'obstacle_spheres',
    'planes',
}


def markers_displays(name: str) -> tuple[list[dict], dict]:
    """Return the marker displays of an RViz configuration, and its global options."""
    rviz = yaml.safe_load((TOP / 'config' / name).read_text())['Visualization Manager']
    displays = [d for d in rviz['Displays'] if d['Class'].endswith('/MarkerArray')]
    return displays, rviz['Global Options']


def test_the_namespaces_of_the_markers_are_these() -> None:
    muscle = BroadMuscle.load('deltoid')
    state = LinkedPlaneSolver(muscle).solve(np.eye(3))
    markers = MuscleMarkers(muscle, 'scapula', 2).update(state, Time()).markers
    assert {marker.ns for marker in markers} == NAMESPACES


def test_rviz_is_set_to_the_topic_and_frame_of_the_node() -> None:
    [display], options = markers_displays('deltoid.rviz')
    assert display['Topic']['Value'] == '/deltoid/markers'
    assert set(display['Namespaces']) == NAMESPACES
    assert options['Fixed Frame'] == 'scapula'
    for display in markers_displays('both_shoulders.rviz')[0]:
        assert set(display['Namespaces']) == NAMESPACES


def test_foxglove_is_set_to_topics_namespaces_and_values_that_exist() -> None:
    layout = json.loads((TOP / 'config' / 'deltoid_foxglove.json').read_text())
    panels = layout['configById']
    scene = panels['3D!muscle']
    assert set(scene['topics']) == {'/deltoid/markers'}
    assert set(scene['topics']['/deltoid/markers']['namespaces']) == NAMESPACES
    assert scene['followTf'] == 'scapula'
    names = BroadMuscle.load('deltoid').band_names
    lengths = [path['value'] for path in panels['Plot!lengths']['paths']]
    assert lengths == [f'/deltoid/band_states.position[{i}]' for i in range(9)]
    for j, place in enumerate(('first', 'second', 'third')):
        arms = [path['value'] for path in panels[f'Plot!moment_arms_{place}']['paths']]
        assert arms == [f'/deltoid/moment_arm_states.position[{3 * i + j}]' for i in range(9)]
    for name, panel in panels.items():
        if name.startswith('Plot!'):
            assert tuple(path['label'] for path in panel['paths']) == names
            assert {path['timestampMethod'] for path in panel['paths']} == {'headerStamp'}
    assert {'markers', 'band_states', 'moment_arm_states'} <= {topic.name for topic in OUTPUTS}
    assert panels['DiagnosticSummary!node']['topicToRender'] == '/diagnostics'


def plotted_series() -> list[list[str]]:
    """Return what PlotJuggler calls each plot's series, from the messages of the default node.

    Its parser of joint states makes `topic/joint/position` of them (ParserROS/ros_parser.cpp).
    """
    solver, thesis = LinkedPlaneSolver(BroadMuscle.load('deltoid')), THESIS_CONVENTION
    state = solver.solve(np.eye(3))
    messages = Answers(solver.muscle.band_names, thesis.coordinates, 'scapula').update(
        Time(), state, state.moment_vectors @ thesis.axes((0.0, 0.0, 0.0)), None
    )
    series = {
        topic: [f'/deltoid/{topic}/{joint}/position' for joint in messages[topic].name]
        for topic in ('band_states', 'moment_arm_states')
    }
    arms = series['moment_arm_states']
    return [series['band_states'], *(arms[j::3] for j in range(3))]


def test_plotjuggler_is_set_to_series_that_exist() -> None:
    root = ElementTree.parse(TOP / 'config' / 'deltoid_plotjuggler.xml').getroot()
    plots = [[curve.get('name') for curve in plot.iter('curve')] for plot in root.iter('plot')]
    assert plots == plotted_series()
    titles = [area.get('name') for area in root.iter('DockArea')]
    assert titles[1:] == [f'Moment arms (m), {each}' for each in THESIS_CONVENTION.coordinates]
    topics = {f'/deltoid/{topic.name}' for topic in OUTPUTS}
    for plugin in root.iterfind('Plugins/plugin'):
        selected = plugin.find('selected_topics').get('value').split(';')
        assert set(selected) <= topics
        assert all(name.startswith(tuple(selected)) for plot in plots for name in plot)
        assert plugin.find('use_header_stamp').get('value') == 'true'


def test_plotjuggler_finds_in_its_layout_what_it_asks_for() -> None:
    root = ElementTree.parse(TOP / 'config' / 'deltoid_plotjuggler.xml').getroot()
    window = root.find('tabbed_widget')
    assert (root.tag, window.get('name')) == ('root', 'Main Window')
    [tab] = window.findall('Tab')
    assert int(tab.get('containers')) == len(tab.findall('Container')) == 1
    [splitter] = root.iter('DockSplitter')
    sizes = [float(size) for size in splitter.get('sizes').split(';')]
    assert int(splitter.get('count')) == len(sizes) == len(splitter.findall('DockArea/plot')) == 4
    assert sum(sizes) == pytest.approx(1.0)
    assert {plot.get('mode') for plot in root.iter('plot')} == {'TimeSeries'}
    streamer = root.find('previouslyLoaded_Streamer').get('name')
    assert streamer in {plugin.get('ID') for plugin in root.iterfind('Plugins/plugin')}


def test_the_plots_of_foxglove_and_plotjuggler_have_the_same_colours() -> None:
    layout = json.loads((TOP / 'config' / 'deltoid_foxglove.json').read_text())
    root = ElementTree.parse(TOP / 'config' / 'deltoid_plotjuggler.xml').getroot()
    colours = [[curve.get('color') for curve in plot.iter('curve')] for plot in root.iter('plot')]
    panels = [each for name, each in layout['configById'].items() if name.startswith('Plot!')]
    assert colours == [[path['color'] for path in panel['paths']] for panel in panels]


def test_every_foxglove_panel_stands_in_the_layout_once() -> None:
    layout = json.loads((TOP / 'config' / 'deltoid_foxglove.json').read_text())

    def leaves(tree: dict | str) -> list[str]:
        return [tree] if isinstance(tree, str) else leaves(tree['first']) + leaves(tree['second'])

    assert sorted(leaves(layout['layout'])) == sorted(layout['configById'])


def is_grouped(name: str) -> bool:
    """Return whether config/diagnostic_aggregator.yaml groups a status of this name.

    By the rules of diagnostic_aggregator's GenericAnalyzer::match.
    """
    file = yaml.safe_load((TOP / 'config' / 'diagnostic_aggregator.yaml').read_text())
    analyzer = file['/**']['ros__parameters']['muscles']
    assert analyzer['type'] == 'diagnostic_aggregator/GenericAnalyzer'
    return (
        any(re.fullmatch(pattern, name) for pattern in analyzer.get('regex', ()))
        or name in analyzer.get('expected', ())
        or any(name.startswith(begin) for begin in analyzer.get('startswith', ()))
        or any(word in name for word in analyzer.get('contains', ()))
    )


@pytest.mark.parametrize(
    ('remaps', 'name'),
    [
        ((), 'muscle_state_publisher: deltoid'),
        (('__node:=left_deltoid',), 'left_deltoid: deltoid (muscle_state_publisher)'),
        (('__ns:=/left',), 'left/muscle_state_publisher: deltoid'),
        (('__ns:=/left', '__node:=m'), 'left/m: deltoid (muscle_state_publisher)'),
    ],
    ids=['as it is', 'renamed', 'in a namespace', 'both'],
)
def test_the_aggregator_groups_a_node_whatever_it_is_called(
    remaps: tuple[str, ...], name: str, peer: Peer
) -> None:
    given = [part for remap in remaps for part in ('-r', remap)]
    node = MuscleStatePublisher(cli_args=['--ros-args', *given])
    with together(peer, node):
        assert peer.until(lambda: bool(peer.diagnostics))
    node.destroy_node()
    assert peer.diagnostics[-1].status[0].name == name
    assert is_grouped(name)
    assert not is_grouped('another_node: deltoid')
