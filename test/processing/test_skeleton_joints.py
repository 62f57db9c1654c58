# SPDX-License-Identifier: Apache-2.0
"""Recorded joints of a skeleton, any number of them, move the bones of a muscle."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bags import joint_state, read_csv, read_messages, write_bag
from random_urdfs import joint, link, robot
from rclpy.serialization import deserialize_message
from reference import Array
from std_msgs.msg import Float64MultiArray

from linkedplane_ros import JOINT_CONVENTIONS, RHYTHMS, BroadMuscle, LinkedPlaneSolver, Skeleton
from linkedplane_ros.commands.main import main
from linkedplane_ros.processing.options import Options
from linkedplane_ros.processing.reading import read_processed
from linkedplane_ros.processing.task import Report, Task, run_task

GIRDLE = Options(muscle='deltoid_girdle', skeleton='shoulder_girdle')
SKELETON = Skeleton.load('shoulder_girdle')
MOVING = SKELETON.moving  # nothing of the SC joint moves the clavicle against the scapula
VALUES = np.random.default_rng(1).uniform(0.05, 0.4, (20, 6))


def process(source: Path, out: Path, options: Options) -> tuple[Report, dict[str, Array]]:
    report = run_task(Task(source, out, options))
    assert report.fault == ''
    _, names, values = read_csv(out)
    return report, dict(zip(names, values.T, strict=True))


def lengths_of(columns: dict[str, Array]) -> Array:
    return np.column_stack([v for name, v in columns.items() if name.startswith('band_lengths/')])


def solved(values: Array, skeleton: Skeleton, muscle: str = 'deltoid_girdle') -> Array:
    """Return the lengths at the values of all coordinates."""
    solver = LinkedPlaneSolver(BroadMuscle.load(muscle))
    return np.array([solver.solve_bones(skeleton.pose(q)).lengths for q in values])


def write_table(path: Path, names: list[str], values: Array) -> Path:
    with path.open('w', newline='') as file:
        writer = csv.writer(file)
        writer.writerow(['time', *names])
        writer.writerows(
            [[repr(0.01 * k), *map(repr, row)] for k, row in enumerate(values.tolist())]
        )
    return path


def whole(values: Array) -> Array:
    """Return values of all nine joints, those of the SC joint 0."""
    return np.column_stack([np.zeros((len(values), 3)), values])


@pytest.mark.parametrize('kind', ['bag', 'table', 'degrees', 'other names'])
def test_recorded_joints_move_the_bones_of_the_muscle(tmp_path: Path, kind: str) -> None:
    order = [3, 0, 5, 1, 4, 2]
    names, values, options = [MOVING[k] for k in order], VALUES[:, order], GIRDLE
    if kind == 'other names':
        names[0] = 'q_0'
        options = replace(GIRDLE, joint_names=[f'{MOVING[3]}:=q_0'])
    if kind == 'bag':
        sent = [
            joint_state(k, ('finger', *names), position=[9.0, *q]) for k, q in enumerate(values)
        ]
        source = write_bag(tmp_path / 'in', sent)
    else:
        scale = np.degrees(1.0) if kind == 'degrees' else 1.0
        source = write_table(tmp_path / 'in.csv', names, scale * values)
        options = replace(options, degrees=kind == 'degrees')
    report, columns = process(source, tmp_path / 'o.csv', options)
    assert report.frames == 20
    assert [name for name in columns if name.startswith('angles/')] == [
        f'angles/{each}' for each in SKELETON.coordinates
    ]
    np.testing.assert_allclose(
        lengths_of(columns), solved(whole(VALUES), SKELETON), rtol=0, atol=1e-12
    )


def test_moment_arms_are_about_the_joints_by_name_and_velocities_make_lengthening(
    tmp_path: Path,
) -> None:
    solver = LinkedPlaneSolver(BroadMuscle.load('deltoid_girdle'))
    rates = [0.1, -0.2, 0.3, 0.4, 0.5, -0.6]
    sent = [
        joint_state(k, MOVING, position=q.tolist(), velocity=rates) for k, q in enumerate(VALUES)
    ]
    source = write_bag(tmp_path / 'in', sent)
    _, columns = process(source, tmp_path / 'o.csv', GIRDLE)
    h = 1e-5
    for k in (0, 7, 19):
        q = whole(VALUES)[k]
        for j, name in enumerate(SKELETON.coordinates):
            ahead, behind = (
                solver.solve_bones(SKELETON.pose(q + step * np.eye(9)[j])).lengths
                for step in (h, -h)
            )
            for i, band in enumerate(solver.muscle.band_names):
                arm = columns[f'moment_arms/{band}/{name}'][k]
                assert arm == pytest.approx(-(ahead - behind)[i] / (2.0 * h), abs=1e-7)
        ahead, behind = (
            solver.solve_bones(SKELETON.pose(q + step * whole(np.array([rates]))[0])).lengths
            for step in (h, -h)
        )
        found = np.array([columns[f'lengthening/{each}'][k] for each in solver.muscle.band_names])
        np.testing.assert_allclose(found, (ahead - behind) / (2.0 * h), rtol=0, atol=1e-7)


def sliding_arm() -> str:
    """Return a robot whose humerus turns about two axes and slides along one."""
    turn = '<axis xyz="{}"/><limit lower="-2" upper="2" effort="1" velocity="1"/>'
    return robot(
        *map(link, ('r1/base', 'a', 'b', 'r1/arm')),
        joint('flex', 'revolute', 'r1/base', 'a', turn.format('1 0 0')),
        joint('spin', 'continuous', 'a', 'b', '<axis xyz="0 0 1"/>'),
        joint('slide', 'prismatic', 'b', 'r1/arm', turn.format('0 0 1')),
    )


@pytest.mark.parametrize('kind', ['bag', 'table'])
def test_sliding_joints_are_in_m_and_continuous_ones_may_turn_on(tmp_path: Path, kind: str) -> None:
    (tmp_path / 'arm.urdf').write_text(sliding_arm())
    options = Options(
        skeleton=str(tmp_path / 'arm.urdf'),
        bone_links=['scapula:=r1/base', 'humerus:=r1/arm'],
        degrees=True,
    )
    values = np.array([(0.1 * k, 0.2 * k + 4 * np.pi, 0.001 * k) for k in range(8)])
    shown = np.column_stack([np.degrees(values[:, :2]), values[:, 2]])
    names = ['flex', 'spin', 'slide']
    if kind == 'bag':
        sent = [joint_state(k, names, position=q.tolist()) for k, q in enumerate(shown)]
        source = write_bag(tmp_path / 'in', sent)
    else:
        source = write_table(tmp_path / 'in.csv', names, shown)
    _, columns = process(source, tmp_path / 'o.csv', options)
    skeleton = Skeleton.load(tmp_path / 'arm.urdf').for_bones(
        ('scapula', 'humerus'), {'scapula': 'r1/base', 'humerus': 'r1/arm'}
    )
    np.testing.assert_allclose(
        lengths_of(columns), solved(values, skeleton, 'deltoid'), rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(columns['angles/slide'], values[:, 2], rtol=0, atol=1e-15)


def test_a_bag_has_the_wrenches_with_their_labels_and_can_be_plotted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sent = [joint_state(k, MOVING, position=q.tolist()) for k, q in enumerate(VALUES)]
    source = write_bag(tmp_path / 'in', sent)
    assert run_task(Task(source, tmp_path / 'out', GIRDLE)).frames == 20
    found = read_messages(tmp_path / 'out')
    wrenches, arms = (
        [
            deserialize_message(data, Float64MultiArray)
            for topic, _, _, data in found
            if topic == f'/deltoid_girdle/{name}'
        ]
        for name in ('wrenches', 'moment_arms')
    )
    solver = LinkedPlaneSolver(BroadMuscle.load('deltoid_girdle'))
    state = solver.solve_bones(SKELETON.pose(whole(VALUES)[5]))
    sizes = [(dim.label.split(':')[0], dim.size, dim.stride) for dim in wrenches[5].layout.dim]
    assert sizes == [('band', 9, 108), ('bone', 2, 12), ('component', 6, 6)]
    assert wrenches[5].layout.dim[1].label == 'bone:clavicle,humerus'
    np.testing.assert_allclose(wrenches[5].data, state.wrenches.ravel(), rtol=0, atol=1e-13)
    assert [dim.size for dim in arms[5].layout.dim] == [9, 9]
    assert arms[5].layout.dim[1].label == f'coordinate:{",".join(SKELETON.coordinates)}'
    process(source, tmp_path / 'table.csv', GIRDLE)
    for output in ('out', 'table.csv'):
        assert main(['plot', str(tmp_path / output), '--svg']) == 0
        read = read_processed(tmp_path / output)
        assert read.arms.shape == (20, 9, 9)
        np.testing.assert_allclose(read.angles, whole(VALUES), rtol=0, atol=1e-15)
    assert 'table_over_time.svg' in capsys.readouterr().out


def test_a_joint_that_never_comes_is_named(tmp_path: Path) -> None:
    sent = [joint_state(k, MOVING[1:], position=q[1:].tolist()) for k, q in enumerate(VALUES)]
    report = run_task(Task(write_bag(tmp_path / 'in', sent), tmp_path / 'o.csv', GIRDLE))
    assert f"waiting for joint '{MOVING[0]}', not seen so far" in report.fault
    table = write_table(tmp_path / 'in.csv', list(MOVING[1:]), VALUES[:, 1:])
    report = run_task(Task(table, tmp_path / 'o.csv', GIRDLE))
    assert MOVING[0] in report.fault


def test_a_loop_and_unknown_joints_are_refused_in_one_line(tmp_path: Path) -> None:
    source = write_bag(tmp_path / 'in', [joint_state(0)])
    report = run_task(Task(source, tmp_path / 'o.csv', replace(GIRDLE, joint_names=['shrug:=q'])))
    assert report.fault.startswith("joint_names: 'shrug' is no joint of shoulder_girdle; those are")
    text = robot(*map(link, 'ab'), *(joint(n, 'fixed', *n) for n in ('ab', 'ba')))
    (tmp_path / 'a.urdf').write_text(text)
    report = run_task(
        Task(source, tmp_path / 'o.csv', replace(GIRDLE, skeleton=str(tmp_path / 'a.urdf')))
    )
    assert report.fault.startswith(f'{tmp_path / "a.urdf"}: ')
    assert '\n' not in report.fault


def test_joints_against_the_thorax_move_a_girdle_that_follows(tmp_path: Path) -> None:
    """By the rhythm's own poses, and with moment arms that include what follows."""
    convention = JOINT_CONVENTIONS['isb_yxy']
    angles = np.array([(0.3, 0.4 + 0.05 * k, 0.1) for k in range(10)])
    sent = [
        joint_state(k, convention.coordinates, position=q) for k, q in enumerate(angles.tolist())
    ]
    options = Options(
        muscle='deltoid', convention='isb_yxy', rhythm='de_groot_brand_2001', rest=[0.5, 0.1, -0.2]
    )
    source = write_bag(tmp_path / 'in', sent)
    _, columns = process(source, tmp_path / 'o.csv', options)
    solver = LinkedPlaneSolver(BroadMuscle.load('deltoid'))
    rhythm, rest = RHYTHMS['de_groot_brand_2001'], options.given_rest

    def lengths(q: Array) -> Array:
        return solver.solve(rhythm.pose(convention.rotation(q), rest=rest).rotation).lengths

    wanted = np.array([lengths(q) for q in angles])
    np.testing.assert_allclose(lengths_of(columns), wanted, rtol=0, atol=1e-9)
    h = 1e-5
    rate = (lengths(angles[4] + [0, h, 0]) - lengths(angles[4] - [0, h, 0])) / (2 * h)
    arms = [columns[f'moment_arms/{band}/elevation'][4] for band in solver.muscle.band_names]
    np.testing.assert_allclose(arms, -rate, rtol=0, atol=1e-6)


def write_slider(folder: Path) -> Options:
    """Write a robot whose humerus slides by 2 cm and turns, and return how it is processed."""
    limit = '<axis xyz="{}"/><limit lower="-0.02" upper="0.02" effort="1" velocity="1"/>'
    text = robot(
        *map(link, ('scapula', 'a', 'humerus')),
        joint('slide', 'prismatic', 'scapula', 'a', limit.format('1 0 0')),
        joint('elev', 'continuous', 'a', 'humerus', '<axis xyz="0 -1 0"/>'),
    )
    (folder / 'x.urdf').write_text(text)
    return Options(skeleton=str(folder / 'x.urdf'))


def test_values_far_beyond_limits_are_a_warning_with_what_was_met(tmp_path: Path) -> None:
    options = write_slider(tmp_path)
    rows = np.array([(1.0 * k, 0.1 * k) for k in range(10)])
    source = write_table(tmp_path / 'mm.csv', ['slide', 'elev'], rows)
    report, _ = process(source, tmp_path / 'o.csv', options)
    [line] = [note for note in report.notes if note.startswith('warning: ')]
    assert '9 of 10 frames far beyond the limits of a joint: slide 0 to 9 m, its limits' in line
    assert line.endswith('-0.02 to 0.02 m; mm?')
    source = write_table(tmp_path / 'm.csv', ['slide', 'elev'], rows * [0.002, 1.0])
    report, _ = process(source, tmp_path / 'o2.csv', options)
    assert list(report.notes) == []
    three = np.full((4, 6), 0.1)
    three[:, :3] = 3.0
    report, _ = process(
        write_table(tmp_path / 'ac.csv', list(MOVING), three), tmp_path / 'o3.csv', GIRDLE
    )
    assert [note.partition('joint: ')[2][:3] for note in report.notes] == ['ac_'] * 3


def test_the_unit_of_angles_is_that_of_joints_that_turn(tmp_path: Path) -> None:
    options = write_slider(tmp_path)
    rows = np.array([(0.001 * k, 10.0 * k) for k in range(9)])
    source = write_table(tmp_path / 'in.csv', ['slide', 'elev_deg'], rows)
    _, columns = process(source, tmp_path / 'o.csv', options)
    np.testing.assert_allclose(columns['angles/slide'], rows[:, 0], rtol=0, atol=1e-15)
    np.testing.assert_allclose(columns['angles/elev'], np.radians(rows[:, 1]), rtol=0, atol=1e-12)
    names = ['ac_protraction_deg', *MOVING[1:]]
    fault = run_task(
        Task(write_table(tmp_path / 'six.csv', names, VALUES), tmp_path / 'o2.csv', GIRDLE)
    ).fault
    assert fault.endswith('one unit for all 6 expected')


def test_a_warning_of_the_range_shows_slides_in_m_and_advises_what_a_skeleton_takes(
    tmp_path: Path,
) -> None:
    rows = np.array([(0.001 * k, 4.0) for k in range(10)])
    source = write_table(tmp_path / 'in.csv', ['slide', 'elev'], rows)
    report, _ = process(source, tmp_path / 'o.csv', write_slider(tmp_path))
    assert 'met, in deg: slide 0 to 0.009 m, elev 229.2 to 229.2;' in report.warning
    assert report.warning.endswith('other joints (--joint-names)? another --skeleton?')


def test_a_hanging_arm_whose_plane_a_rhythm_needs_is_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for convention, loses in ('flexion_abduction_rotation', True), ('isb_yxy', False):
        names = list(JOINT_CONVENTIONS[convention].coordinates)
        rows = np.array([(0.01 * k, 0.01 * k, 0.1) for k in range(10)])
        source = write_table(tmp_path / 'in.csv', names, rows)
        words = ['--convention', convention, '--rhythm', 'de_groot_brand_2001', '--force']
        assert main(['process', str(source), str(tmp_path / 'o.csv'), *words]) == 0
        shown = capsys.readouterr()
        caution = f'goes by the plane of elevation, which {convention} does not say'
        assert (caution in shown.err) == loses
        assert ('7 of 10 frames near the singularity' in shown.out) == loses


@pytest.mark.parametrize('muscle', ['deltoid', 'deltoid_girdle'])
def test_bones_of_which_nothing_is_recorded_are_said_to_be_held(
    tmp_path: Path, muscle: str
) -> None:
    names = list(JOINT_CONVENTIONS['flexion_abduction_rotation'].coordinates)
    source = write_table(tmp_path / 'in.csv', names, VALUES[:, :3])
    report, _ = process(source, tmp_path / 'o.csv', Options(muscle=muscle))
    held = ['clavicle: held at rest, only the humerus moves'] * (muscle == 'deltoid_girdle')
    assert [note.partition(';')[0] for note in report.notes] == held
    facts = (tmp_path / 'o.csv').read_text()
    assert ('# bones_held_at_rest: clavicle\n' in facts) == bool(held)
