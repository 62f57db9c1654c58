# SPDX-License-Identifier: Apache-2.0
"""Tables and motion files processed: the same numbers whatever the format."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from bags import (
    EXACT,
    T0,
    answer_numbers,
    node_answers,
    odd_motion,
    read_csv,
    read_messages,
    write_bag,
)
from optional import requires
from rclpy.serialization import deserialize_message
from ros_harness import TOPICS

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.processing.options import Options
from linkedplane_ros.processing.task import Task, run_task

TSM = Options(convention='opensim_tsm')


def test_a_motion_file_a_table_and_a_bag_of_one_motion_agree(shared: Path, tmp_path: Path) -> None:
    folder = shared / 'recordings'
    made = {}
    for name in ('abduction.mot', 'abduction.csv', 'abduction_mcap'):
        report = run_task(Task(folder / name, tmp_path / f'{name}.csv', TSM))
        assert (report.fault, report.frames) == ('', 1091)
        made[name] = read_csv(tmp_path / f'{name}.csv')
    _, names, mot = made['abduction.mot']
    solver, convention = (
        LinkedPlaneSolver(BroadMuscle.load('deltoid')),
        JOINT_CONVENTIONS['opensim_tsm'],
    )
    for values in (mot, made['abduction.csv'][2]):
        state = solver.solve(convention.rotation(values[500, 1:4]))
        np.testing.assert_allclose(values[500, 5:14], state.lengths, rtol=0, atol=EXACT)
    # rad and deg with eight decimals: a few micrometres at most
    for other in ('abduction.csv', 'abduction_mcap'):
        assert made[other][1] == names
        np.testing.assert_allclose(made[other][2][:, 1:14], mot[:, 1:14], rtol=0, atol=1e-6)
    assert made['abduction.mot'][0]['velocities'] == 'differentiated'
    assert made['abduction_mcap'][0]['velocities'].startswith('recorded')
    assert np.isnan(made['abduction_mcap'][2][:, names.index('lengthening/middle_1')]).all()


def test_lengthening_from_a_table_is_the_slope_of_the_length(tmp_path: Path) -> None:
    times = 0.01 * np.arange(201)
    lines = ['time,flexion,abduction,rotation']
    lines += [f'{t!r},{0.5 + 0.4 * math.sin(2 * t)!r},0.3,0.1' for t in times.tolist()]
    (tmp_path / 'sine.csv').write_text('\n'.join(lines) + '\n')
    run_task(Task(tmp_path / 'sine.csv', tmp_path / 'out.csv'))
    _, names, values = read_csv(tmp_path / 'out.csv')
    length, speed = (values[:, names.index(f'{kind}/anterior_2')]
                     for kind in ('band_lengths', 'lengthening'))  # fmt: skip
    # m/s: both are differences over 10 ms of a motion of 2 rad/s
    np.testing.assert_allclose(speed[1:-1], np.gradient(length, times)[1:-1], rtol=0, atol=2e-5)


@pytest.mark.parametrize('size', [1, 2, 7, 1000])
def test_the_size_of_a_chunk_does_not_show(
    tmp_path: Path, size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    bag = write_bag(tmp_path / 'in', odd_motion())
    lines = ['time,flexion,abduction,rotation']
    lines += [f'{0.01 * k},{0.1 * math.sin(k)},0.3,{"nan" if k == 20 else 0.1}' for k in range(50)]
    (tmp_path / 'in.csv').write_text('\n'.join(lines) + '\n')
    whole = [run_task(Task(source, tmp_path / f'whole{k}.csv'))
             for k, source in enumerate((bag, tmp_path / 'in.csv'))]  # fmt: skip
    for module in ('bag_motion', 'table_motion'):
        monkeypatch.setattr(f'linkedplane_ros.recordings.{module}.ROWS', size)
    for k, report in enumerate(whole):
        again = run_task(Task(report.task.source, tmp_path / f'part{k}.csv'))
        assert again.refused == report.refused
        part, all_at_once = (read_csv(tmp_path / f'{name}{k}.csv')[2] for name in ('part', 'whole'))
        # differences in time and products of matrices round otherwise in other company
        np.testing.assert_allclose(part, all_at_once, rtol=1e-12, atol=1e-15)


@requires('pyarrow')
def test_parquet_holds_the_numbers_of_csv(tmp_path: Path) -> None:
    from pyarrow import parquet

    source = write_bag(tmp_path / 'in', odd_motion())
    for name in ('out.csv', 'out.parquet'):
        assert run_task(Task(source, tmp_path / name)).fault == ''
    facts, names, values = read_csv(tmp_path / 'out.csv')
    table = parquet.read_table(tmp_path / 'out.parquet')
    assert table.column_names == ['stamp', *names]
    for i, name in enumerate(names):
        found = table[name].to_numpy(zero_copy_only=False)
        np.testing.assert_allclose(found, values[:, i], rtol=1e-15, atol=0)  # time: its last bit
    metadata = {key.decode(): value.decode() for key, value in table.schema.metadata.items()}
    assert facts.items() <= metadata.items()
    assert table['stamp'][0].value == T0


def test_a_motion_file_becomes_a_bag_that_the_node_would_answer_alike(
    ros: None, shared: Path, tmp_path: Path
) -> None:
    task = Task(shared / 'recordings' / 'flexion.mot', tmp_path / 'out', TSM)
    assert run_task(task).fault == ''
    found = read_messages(tmp_path / 'out')
    said = node_answers(found, joint_convention='opensim_tsm', **{'markers.details': False})
    del said['markers'][0]
    for topic, answers in said.items():
        ours = [data for name, _, _, data in found if name == f'/deltoid/{topic}']
        assert len(ours) == len(answers)
        for mine, theirs in zip(ours, answers, strict=True):
            a, b = (answer_numbers(deserialize_message(x, TOPICS[topic])) for x in (mine, theirs))
            np.testing.assert_allclose(a, b, rtol=0, atol=EXACT)


def test_a_filter_and_a_rate_are_carried_out_and_recorded(tmp_path: Path) -> None:
    times = 0.01 * np.arange(401)
    noisy = 0.5 + 0.3 * np.sin(2 * np.pi * 0.5 * times) + 0.05 * np.sin(2 * np.pi * 20 * times)
    lines = ['time,flexion,abduction,rotation', *(f'{t!r},{q!r},0.3,0.1'
             for t, q in zip(times.tolist(), noisy.tolist(), strict=True))]  # fmt: skip
    (tmp_path / 'in.csv').write_text('\n'.join(lines) + '\n')
    task = Task(tmp_path / 'in.csv', tmp_path / 'out.csv', Options(rate=50.0, lowpass=6.0))
    assert run_task(task).frames == 201
    facts, _, values = read_csv(tmp_path / 'out.csv')
    assert (facts['resampled_to_hz'], facts['velocities']) == ('50', 'differentiated')
    assert facts['lowpass_hz'].startswith('6 ')
    np.testing.assert_allclose(np.diff(values[:, 0]), 0.02, atol=1e-9)
    middle = slice(20, -20)
    want = 0.5 + 0.3 * np.sin(2 * np.pi * 0.5 * values[:, 0])
    np.testing.assert_allclose(values[middle, 1], want[middle], rtol=0, atol=2e-3)  # rad


def test_the_output_says_what_was_read_and_how(shared: Path, tmp_path: Path) -> None:
    motions = shared / 'recordings'
    bag = write_bag(tmp_path / 'in', odd_motion())
    for task, said in (
        (Task(motions / 'flexion.mot', tmp_path / 'a.csv', TSM),
         {'read_in': 'deg: inDegrees in the file', 'columns': 'plane_elv, shoulder_elv, axial_rot',
          'velocities': 'differentiated'}),
        (Task(motions / 'flexion.csv', tmp_path / 'b.csv', TSM),
         {'read_in': 'rad: the names of the columns',
          'columns': 'plane_elv_rad, shoulder_elv_rad, axial_rot_rad'}),
        (Task(bag, tmp_path / 'c.csv'),
         {'topic': '/joint_states', 'velocities': 'recorded, where the recording has them',
          'angles_topic': ''}),
        (Task(bag, tmp_path / 'd.csv', Options(rate=50.0)),
         {'velocities': 'differentiated', 'angles_topic': '/deltoid/joint_states'}),
    ):  # fmt: skip
        report = run_task(task)
        assert report.fault == ''
        facts, _, _ = read_csv(task.target)
        assert said.items() <= facts.items()
