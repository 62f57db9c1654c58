# SPDX-License-Identifier: Apache-2.0
"""Which band enters which bone sphere: the exact distance, the spec's figures, further spheres."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, ModelError, WrapState
from linkedplane_ros.solver.interference import closest_points
from linkedplane_ros.study import interference
from linkedplane_ros.study.experiments import MOTIONS, simulate_motion, simulate_motions
from linkedplane_ros.study.interference import (
    PRINTED,
    REVERSED_Z,
    REVERSED_ZY,
    Checks,
    add_spheres,
    apply_reading,
    check_experiments,
)

DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
SHOWN = 0.005e-3  # m: half of the last digit of the figures below


def read(reading: str) -> Checks:
    """Return the checks of the deltoid in a reading of its obstacle spheres' frame."""
    return check_experiments(simulate_motions(apply_reading(DELTOID, reading)))


@pytest.fixture(scope='module')
def printed() -> Checks:
    """Return the checks of the printed parameters."""
    return read(PRINTED)


def distance_to_polyline(X: np.ndarray, path: np.ndarray) -> float:
    """Return the least distance of a point from a polyline, m."""
    along = path[1:] - path[:-1]
    share = np.clip(((X - path[:-1]) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    return float(np.linalg.norm(path[:-1] + share[:, None] * along - X, axis=1).min())


# The distance


def test_the_distance_of_a_path_is_that_of_a_very_fine_polyline() -> None:
    # 1000 points on an arc: its chords pass 1e-9 m under it at most
    random = np.random.default_rng(7)
    on_arc = 0
    for motion in MOTIONS:
        for state in simulate_motion(SOLVER, motion).states:
            paths = state.paths(1000)
            beside = [path[len(path) // 2] + random.normal(0.0, 0.01, 3) for path in paths]
            centres = np.array([*DELTOID.interference_centres, *beside])
            for path, places in zip(paths, closest_points(state, centres), strict=True):
                for X, nearest in zip(centres, places, strict=True):
                    distance = np.linalg.norm(X - nearest)
                    assert distance == pytest.approx(distance_to_polyline(X, path), abs=2e-9)
                    assert distance_to_polyline(nearest, path) < 2e-9
                    ends = np.linalg.norm(nearest - path[[0, 1, -2, -1]], axis=1)
                    on_arc += len(path) > 2 and ends.min() > 1e-3
    assert on_arc > 20  # arcs were met, not only their ends


# The figures of erratum 9


def test_132_of_702_checks_find_a_band_in_a_sphere_at_25_of_26_poses(
    printed: Checks,
) -> None:
    assert (printed.count, printed.poses) == (702, 26)
    assert len(printed.entries) == 132
    assert printed.poses_entered == 25


def test_the_counts_stand_off_the_edge(printed: Checks) -> None:
    # m: no entry or miss is so shallow that an error of the solver (1e-9 m) could change a count
    assert min(np.abs(each).min() for each in printed.depths) > 2e-5


def test_the_one_pose_that_no_band_spoils_is_abduction_at_30_deg(
    printed: Checks,
) -> None:
    clean = [
        (one.motion.name, round(math.degrees(one.angles[at])))
        for one, depths in zip(printed.experiments, printed.depths, strict=True)
        for at in np.flatnonzero((depths < 0.0).all(axis=(1, 2)))
    ]
    assert clean == [('abduction', 30)]


def test_the_deepest_entry_is_20_mm_into_the_humeral_head_in_flexion(
    printed: Checks,
) -> None:
    deepest = max(printed.entries, key=lambda entry: entry.depth)
    assert deepest.depth == pytest.approx(20.18e-3, abs=SHOWN)
    assert (deepest.motion, round(math.degrees(deepest.angle))) == ('flexion', 50)
    assert (deepest.band, deepest.sphere) == ('middle_3', 'sphere_4')


def test_at_neutral_two_bands_enter_the_humeral_head_by_4_and_7_mm(
    printed: Checks,
) -> None:
    at_neutral = [entry for entry in printed.entries if entry.angle == 0.0]
    found = {(entry.band, entry.sphere): 1e3 * entry.depth for entry in at_neutral}
    assert found == {
        ('anterior_3', 'sphere_4'): pytest.approx(6.70, abs=0.005),
        ('middle_1', 'sphere_4'): pytest.approx(4.10, abs=0.005),
    }
    assert len(at_neutral) == 6  # once with each motion


def test_the_two_most_anterior_bands_enter_nothing(printed: Checks) -> None:
    assert printed.entries_of_bands.tolist() == [0, 0, 11, 13, 14, 18, 30, 24, 22]
    assert (printed.deepest_of_bands[:2] < 0.0).all()


def test_nearly_half_of_the_entries_are_of_bands_that_touch_no_obstacle(
    printed: Checks,
) -> None:
    # the straight line between their ends passes through bone
    straight = [entry for entry in printed.entries if entry.wrap != WrapState.WRAPPED]
    assert len(straight) == 61
    assert max(entry.depth for entry in straight) == pytest.approx(18.09e-3, abs=SHOWN)


def test_an_entry_says_where(printed: Checks) -> None:
    centres = dict(zip(DELTOID.interference_names, DELTOID.interference_centres, strict=True))
    radii = dict(zip(DELTOID.interference_names, DELTOID.interference_radii, strict=True))
    for entry in printed.entries:
        inside = radii[entry.sphere] - np.linalg.norm(entry.point - centres[entry.sphere])
        assert entry.depth == pytest.approx(inside, abs=1e-12)
        assert entry.depth >= 0.0


# The alternative reading


def test_with_z_reversed_bands_1_to_3_are_clear_and_7_to_9_are_not() -> None:
    found = read(REVERSED_Z)
    assert len(found.entries) == 72
    assert found.poses_entered == 17
    assert found.entries_of_bands.tolist() == [0, 0, 0, 1, 6, 7, 15, 21, 22]
    deepest = [0.0, 1.99, 5.96, 16.88, 15.65, 17.05, 18.09]
    np.testing.assert_allclose(
        np.maximum(1e3 * found.deepest_of_bands[2:], 0.0), deepest, atol=0.005
    )


def test_with_z_reversed_no_band_enters_at_neutral() -> None:
    assert not [each for each in read(REVERSED_Z).entries if each.angle == 0.0]


def test_with_y_following_the_reversed_z_little_is_gained() -> None:
    found = read(REVERSED_ZY)
    assert (len(found.entries), found.poses_entered) == (118, 23)


def test_a_reversed_axis_is_that_of_the_frame_with_its_factors_swapped() -> None:
    state = LinkedPlaneSolver(apply_reading(DELTOID, REVERSED_ZY)).solve(np.eye(3))
    for i, P in enumerate(DELTOID.origins):
        x = DELTOID.humeral_point - P
        x /= np.linalg.norm(x)
        z = np.cross(DELTOID.ground_point - P, x)  # the thesis: x cross (SC - P)
        z /= np.linalg.norm(z)
        y = np.cross(z, x)
        place = P + DELTOID.sphere_centres[i] @ np.array((x, y, z))
        np.testing.assert_allclose(state.sphere_centres[i], place, atol=1e-12)


# Further spheres


SPHERES = """
units: {length: mm}
interference_spheres:
  sphere_1: {centre: [100.0, 0.0, 0.0], radius: 20.0}
"""


def test_a_file_adds_spheres_and_changes_nothing_else(tmp_path: Path, printed: Checks) -> None:
    path = tmp_path / 'lost.yaml'
    path.write_text(SPHERES)
    muscle = add_spheres(DELTOID, path)
    assert muscle.interference_names == ('sphere_4', 'sphere_5', 'sphere_6', 'sphere_1')
    assert muscle.interference_centres[3].tolist() == [0.1, 0.0, 0.0]
    found = interference.check_experiments(simulate_motions(muscle))
    assert found.count == 936
    for before, after in zip(printed.depths, found.depths, strict=True):
        np.testing.assert_array_equal(after[:, :, :3], before)


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('', 'the file: a mapping of keys expected, nothing given'),
        ('units: {length: mm}', 'interference_spheres: missing'),
        ('interference_spheres: {}', 'units: missing'),
        ('units: {length: mm}\ninterference_spheres: {}', 'at least one sphere expected'),
        (SPHERES.replace('mm', 'inch'), 'units.length'),
        (SPHERES.replace('20.0', '-70.0'), 'sphere_1.radius: -70 given, > 0 expected'),
        (SPHERES.replace('20.0', '.nan'), 'sphere_1.radius: a finite number expected'),
        (SPHERES.replace('[100.0, 0.0, 0.0]', '[0.0]'), 'a list of 3 numbers expected'),
        (SPHERES.replace('sphere_1', 'sphere_4'), 'sphere_4: the model has one of this name'),
        ('a: [', 'not valid YAML'),
    ],
)
def test_a_file_of_spheres_that_is_no_good_is_refused_in_one_line(
    tmp_path: Path, text: str, reason: str
) -> None:
    path = tmp_path / 'lost.yaml'
    path.write_text(text)
    with pytest.raises(ModelError) as caught:
        add_spheres(DELTOID, path)
    assert str(caught.value).startswith(str(path))
    assert reason in str(caught.value)
    assert '\n' not in str(caught.value)
