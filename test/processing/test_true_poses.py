# SPDX-License-Identifier: Apache-2.0
"""Recordings of the poses of all of a muscle's bones: lengths, wrenches, moment arms."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bags import STORE, read_csv, read_messages, write_bag
from pose_bags import Standing, against, beyond, pose_bag, seen_from, since, tf_message, wandering
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, Skeleton
from linkedplane_ros.processing.options import Options
from linkedplane_ros.processing.task import Report, Task, run_task

EXACT = 1e-12  # m
POSES = Options(muscle='deltoid_girdle', humerus='humerus', scapula='scapula', clavicle='clavicle')
GIRDLE = Options(muscle='deltoid_girdle', input='tf', skeleton='shoulder_girdle')
MIRROR = np.diag((-1.0, 1.0, 1.0))
ISB = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
RECORDINGS = 'girdle_abduction_mcap', 'girdle_shrug_mcap'


def process(source: Path, out: Path, options: Options) -> tuple[Report, dict[str, Array]]:
    """Return the report of a recording and its columns."""
    report = run_task(Task(source, out, options))
    assert report.fault == ''
    _, names, values = read_csv(out)
    return report, dict(zip(names, values.T, strict=True))


def columns_of(columns: dict[str, Array], start: str) -> Array:
    """Return the columns whose names begin so, (m, k)."""
    return np.column_stack([each for name, each in columns.items() if name.startswith(start)])


def golden_poses(shared: Path) -> tuple[list[dict[str, Standing]], Array, Array]:
    """Return poses of clavicle and humerus, lengths (24, 9) m and wrenches (24, 9, 2, 6)."""
    path = shared / 'golden' / 'deltoid_clavicle_states.csv'
    with path.open(encoding='utf-8') as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith('#')))
    moments = []
    for row in rows[::9]:
        moment = {}
        for bone in ('clavicle', 'humerus'):
            R = [[float(row[f'{bone}_R{i}{j}']) for j in range(3)] for i in range(3)]
            moment[bone] = np.array(R), np.array([float(row[f'{bone}_t{x}_m']) for x in 'xyz'])
        moments.append(moment)
    lengths = np.array([float(row['length_m']) for row in rows]).reshape(-1, 9)
    wrenches = np.array([
        [
            [float(row[f'{bone}_{each}']) for each in (
                'moment_x_m', 'moment_y_m', 'moment_z_m', 'force_x', 'force_y', 'force_z')]
            for bone in ('clavicle', 'humerus')
        ]
        for row in rows
    ]).reshape(-1, 9, 2, 6)  # fmt: skip
    return moments, lengths, wrenches


def recorded_moments(bag: Path) -> list[dict[str, Standing]]:
    """Return where each bone's frame stands in the thorax, moment by moment."""
    moments: dict[int, dict[str, Standing]] = {}
    for topic, kind, time, data in read_messages(bag):
        if topic != '/tf':
            continue
        for each in STORE.deserialize_cdr(data, kind).transforms:  # type: ignore[attr-defined]
            turn, place = each.transform.rotation, each.transform.translation
            R = Rotation.from_quat((turn.x, turn.y, turn.z, turn.w)).as_matrix()
            moments.setdefault(time, {})[each.child_frame_id] = (
                R, np.array((place.x, place.y, place.z))
            )  # fmt: skip
    return list(moments.values())


@pytest.mark.parametrize('rest', [None, ['coincide'], ['clavicle:=0,0,0,0,0,0']])
def test_the_golden_poses_as_a_bag_give_the_golden_lengths_and_wrenches(
    shared: Path, tmp_path: Path, rest: list[str] | None
) -> None:
    moments, lengths, wrenches = golden_poses(shared)
    lab = [
        {'scapula': wandering(k)} | {bone: beyond(wandering(k), at) for bone, at in each.items()}
        for k, each in enumerate(moments)
    ]
    source = pose_bag(tmp_path / 'in', lab)
    _, columns = process(source, tmp_path / 'o.csv', replace(POSES, rest_frames=rest))
    np.testing.assert_allclose(columns_of(columns, 'band_lengths/'), lengths, rtol=0, atol=1e-9)
    found = columns_of(columns, 'wrenches/').reshape(-1, 9, 2, 6)
    np.testing.assert_allclose(found[..., :3], wrenches[..., :3], rtol=0, atol=1e-7)  # m
    np.testing.assert_allclose(found[..., 3:], wrenches[..., 3:], rtol=0, atol=1e-6)
    assert list(columns)[-10].endswith('posterior_3/humerus/fz')


@pytest.mark.parametrize('recording', RECORDINGS)
def test_recorded_girdles_are_solved_where_their_bones_are(
    shared: Path, tmp_path: Path, recording: str
) -> None:
    bag = shared / 'recordings' / recording
    options = replace(POSES, rest_frames=['clavicle:=first', 'humerus:=coincide'])
    report, columns = process(bag, tmp_path / 'o.csv', options)
    moments = [against(each, 'scapula') for each in recorded_moments(bag)]
    assert report.frames == len(moments)
    solver = LinkedPlaneSolver(BroadMuscle.load('deltoid_girdle'))
    for k in range(0, len(moments), 40):
        now = moments[k]
        state = solver.solve_bones(
            {'humerus': now['humerus'], 'clavicle': since(moments[0]['clavicle'], now['clavicle'])}
        )
        found = columns_of(columns, 'band_lengths/')[k]
        np.testing.assert_allclose(found, state.lengths, rtol=0, atol=EXACT)
        found = columns_of(columns, 'wrenches/')[k].reshape(9, 2, 6)
        np.testing.assert_allclose(found, state.wrenches, rtol=0, atol=1e-10)


def test_where_nobody_says_a_frame_that_begins_far_off_is_at_rest_there_and_a_line_says_so(
    shared: Path, tmp_path: Path
) -> None:
    bag = shared / 'recordings' / 'girdle_shrug_mcap'
    said = replace(POSES, rest_frames=['clavicle:=first', 'humerus:=coincide'])
    _, wanted = process(bag, tmp_path / 'a.csv', said)
    report, found = process(bag, tmp_path / 'b.csv', POSES)
    [line] = report.notes
    assert line.startswith('warning: the frame of clavicle begins 155 mm from that of scapula')
    assert 'rest_frames says otherwise' in line
    assert all(np.array_equal(found[name], each, equal_nan=True) for name, each in wanted.items())


def test_a_shrug_changes_the_anterior_bands_although_the_arm_hardly_turns(
    shared: Path, tmp_path: Path
) -> None:
    bag = shared / 'recordings' / 'girdle_shrug_mcap'
    # the arm against the thorax, as if the scapula stood still with it
    arm = Options(muscle='deltoid_girdle', humerus='humerus', scapula='thorax')
    _, of_arm = process(bag, tmp_path / 'a.csv', arm)
    assert np.degrees(np.ptp(columns_of(of_arm, 'angles/'), axis=0)).max() < 11.0
    _, held = process(bag, tmp_path / 'b.csv', replace(POSES, clavicle=None))
    _, moving = process(bag, tmp_path / 'c.csv', POSES)
    for band in ('anterior_1', 'anterior_2'):
        name = f'band_lengths/{band}'
        assert np.ptp(of_arm[name]) < 3e-3  # m
        assert np.ptp(moving[name]) > 7e-3
        assert np.ptp(moving[name]) > np.ptp(held[name]) + 1.5e-3  # what the clavicle adds


@pytest.mark.parametrize('case', ['left', 'isb', 'several messages', 'deep tree'])
def test_the_same_motion_recorded_in_another_way_has_the_same_lengths(
    shared: Path, tmp_path: Path, case: str
) -> None:
    moments, lengths, _ = golden_poses(shared)
    options = POSES
    sent = []
    for k, moment in enumerate(moments):
        frames = {'scapula': (np.eye(3), np.zeros(3)), **moment}
        if case == 'left':
            frames = {n: (MIRROR @ R @ MIRROR, MIRROR @ t) for n, (R, t) in frames.items()}
            options = replace(POSES, side='left')
        elif case == 'isb':
            frames = {n: (ISB.T @ R @ ISB, ISB.T @ t) for n, (R, t) in frames.items()}
            options = replace(POSES, frame_axes='isb')
        hung = [('torso', name, beyond(wandering(k), at)) for name, at in frames.items()]
        if case == 'several messages':
            sent += [tf_message(k, [each]) for each in hung]
        elif case == 'deep tree':
            below = seen_from(frames['clavicle'], frames['humerus'])
            hung = [('map', 'torso', wandering(3 * k)), *hung[:2], ('clavicle', 'humerus', below)]
            sent.append(tf_message(k, hung))
        else:
            sent.append(tf_message(k, hung))
    source = write_bag(tmp_path / 'in', sent)
    _, columns = process(source, tmp_path / 'o.csv', options)
    np.testing.assert_allclose(columns_of(columns, 'band_lengths/'), lengths, rtol=0, atol=1e-9)


def test_lengthening_is_the_difference_from_the_frame_before(shared: Path, tmp_path: Path) -> None:
    bag = shared / 'recordings' / 'girdle_shrug_mcap'
    _, columns = process(bag, tmp_path / 'o.csv', POSES)
    lengths, rates = columns_of(columns, 'band_lengths/'), columns_of(columns, 'lengthening/')
    assert np.isnan(rates[0]).all()
    np.testing.assert_allclose(rates[1:], np.diff(lengths, axis=0) / 0.01, rtol=0, atol=1e-9)


def girdle_at(q: Array) -> dict[str, Standing]:
    """Return the frames of the bundled girdle's links in the thorax."""
    girdle = Skeleton.load('shoulder_girdle')
    names = 'thorax', 'clavicle', 'scapula', 'humerus'
    return {'thorax': (np.eye(3), np.zeros(3)), **Skeleton(girdle.tree, names, names).pose(q)}


@pytest.mark.parametrize('thorax', [True, False])
def test_with_a_skeleton_joints_are_found_from_poses_and_moment_arms_are_about_them(
    tmp_path: Path, thorax: bool
) -> None:
    random = np.random.default_rng(3)
    skeleton = Skeleton.load('shoulder_girdle')
    lower, upper = np.array(skeleton.limits).T
    wanted = random.uniform(0.8 * lower, 0.8 * upper, (12, 9))
    wanted[:, 7] = random.uniform(0.3, 2.0, 12)
    frames = [
        {name: beyond(wandering(k), at) for name, at in girdle_at(q).items()}
        for k, q in enumerate(wanted)
    ]
    source = pose_bag(tmp_path / 'in', frames)
    options = replace(GIRDLE, thorax='thorax' if thorax else None)
    report, columns = process(source, tmp_path / 'o.csv', options)
    assert report.notes == () or 'fits the measured poses to' in report.notes[0]
    found = columns_of(columns, 'angles/')
    known = slice(0 if thorax else 3, 9)  # nothing of the SC joint is seen from the scapula
    np.testing.assert_allclose(found[:, known], wanted[:, known], rtol=0, atol=1e-7)
    arms = columns_of(columns, 'moment_arms/').reshape(12, 9, 9)
    solver = LinkedPlaneSolver(BroadMuscle.load('deltoid_girdle'))
    h = 1e-5
    for k, q in enumerate(wanted):
        for j in range(9):
            ahead, behind = (
                solver.solve_bones(skeleton.pose(q + step * np.eye(9)[j])) for step in (h, -h)
            )
            rate = (ahead.lengths - behind.lengths) / (2.0 * h)
            smooth = (ahead.wrap == behind.wrap) & (np.abs(rate) < 0.1)
            np.testing.assert_allclose(arms[k, smooth, j], -rate[smooth], rtol=0, atol=2e-6)


def test_a_skeleton_that_does_not_fit_is_a_warning(tmp_path: Path) -> None:
    q = np.zeros((3, 9))
    q[:, 7] = (0.5, 1.0, 2.9)  # beyond the elevation's limit of 2.53
    source = pose_bag(tmp_path / 'in', [girdle_at(each) for each in q])
    report, columns = process(source, tmp_path / 'o.csv', GIRDLE)
    assert report.notes[-1].startswith('warning: the skeleton fits the measured poses to 21 deg')
    assert columns['angles/elevation'].max() == 2.53


@pytest.mark.parametrize(
    ('options', 'line'),
    [
        (
            replace(POSES, clavicle=None, rest_frames=['first']),
            'deltoid_girdle: no frame of clavicle; its bones are scapula, clavicle, humerus: '
            '--clavicle NAME',
        ),
        (
            replace(POSES, rest_frames=['sternum:=first']),
            "rest_frames: 'sternum' has no frame; those are scapula, clavicle, humerus",
        ),
        (
            replace(POSES, rest_frames=['clavicle:=1,2,3']),
            "rest_frames: '1,2,3' given; coincide, first, six numbers",
        ),
        (replace(POSES, rest_frames=['last']), "rest_frames: 'last' given; coincide, first,"),
        (replace(POSES, clavicle='sternum'), 'no pose of sternum; frames met: '),
        (replace(GIRDLE, skeleton='hip'), "no link of that name for bone 'scapula'"),
    ],
)
def test_what_is_missing_is_named(tmp_path: Path, options: Options, line: str) -> None:
    source = pose_bag(tmp_path / 'in', [girdle_at(np.zeros(9))] * 3)
    report = run_task(Task(source, tmp_path / 'o.csv', options))
    assert line in report.fault


@pytest.mark.parametrize('case', ['apart', 'loop', 'mm', 'nan', 'quaternion'])
def test_poses_that_are_none_are_counted_by_reason(tmp_path: Path, case: str) -> None:
    good = {name: at for name, at in girdle_at(np.zeros(9)).items() if name != 'thorax'}
    sent = [tf_message(k, [('lab', name, at) for name, at in good.items()]) for k in range(4)]
    R, t = good['clavicle']
    if case == 'apart':
        sent[1:] = [tf_message(k, [('map', 'clavicle', (R, t))]) for k in range(1, 4)]
    elif case == 'loop':
        sent[1:] = [tf_message(k, [('clavicle', 'clavicle', (R, t))]) for k in range(1, 4)]
    elif case == 'mm':
        mm = [('lab', name, (R, 1e3 * t)) for name, (R, t) in good.items()]
        sent[1:] = [tf_message(k, mm) for k in range(1, 4)]
    elif case == 'nan':
        hung = [('lab', name, (R, np.nan * t)) for name, (R, t) in good.items()]
        sent[1:] = [tf_message(k, hung) for k in range(1, 4)]
    else:
        broken = [tf_message(k, [('lab', 'humerus', good['humerus'])]) for k in range(1, 4)]
        sent[1:] = [(*each[:3], each[3][:-32] + bytes(32)) for each in broken]
    report = run_task(Task(write_bag(tmp_path / 'in', sent), tmp_path / 'o.csv', POSES))
    assert (report.fault, report.frames) == ('', 1)
    reason = {'mm': 'far', 'nan': 'not_finite', 'quaternion': 'not_unit'}.get(case, case)
    if case == 'apart':
        assert report.refused == {}  # as before: nothing is due while bones are apart
    else:
        assert report.refused[reason] in (1, 3)
        assert report.first[reason].startswith('message 2, ')
