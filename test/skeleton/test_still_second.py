# SPDX-License-Identifier: Apache-2.0
"""The first second in which the arm hangs still."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from girdle_recordings import girdle_poses
from optional import requires
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import RHYTHMS, LinkedPlaneError, Rest
from linkedplane_ros.skeleton.girdle import GIRDLE, HUMERUS
from linkedplane_ros.skeleton.still_second import StillSecond, find_rest

Poses = Iterator[tuple[int, Mapping[str, Array]]]


def stamped(turns: Any, rate: float = 100.0) -> Poses:
    """Yield poses of the humerus alone, from angles, rad, at a rate, Hz."""
    for k, angles in enumerate(turns):
        yield round(k * 1e9 / rate), {'humerus': HUMERUS.rotation(angles)}


def swinging(count: int) -> Array:
    """Return angles (count, 3) of an arm that swings by 0.3 rad within 0.6 s, at 100 Hz."""
    swing = 0.1 + 0.3 * np.sin(np.arange(count) * 2 * np.pi / 60) ** 2
    return np.column_stack((np.full(count, 0.3), swing, np.zeros(count)))


def test_the_rest_is_the_mean_of_the_first_still_second() -> None:
    noise = np.random.default_rng(3).normal(0.0, 0.003, (101, 3))
    still = np.array((0.4, 0.25, -0.3)) + noise
    found = find_rest(stamped([*swinging(90), *still, *swinging(60)]))
    mean = Rotation.from_matrix([HUMERUS.rotation(each) for each in still]).mean().as_matrix()
    assert found.start == 90 * 10**7
    assert found.rest is not None
    assert found.rest.humerus == pytest.approx(HUMERUS.angles(mean)[:2].tolist(), abs=1e-9)
    assert (found.rest.scapula, found.rest.clavicle) == (Rest().scapula, Rest().clavicle)


def test_live_and_in_an_array_it_is_the_same() -> None:
    still, answers = StillSecond(), []
    angles = [*swinging(90), *([(0.4, 0.25, -0.3)] * 150)]
    for stamp, bones in stamped(angles):
        answers.append(still.add(stamp, bones))
    assert answers.index(still.rest) == 190  # as soon as the second is over
    assert set(answers[:190]) == {None}
    assert still.rest == find_rest(stamped(angles)).rest


@pytest.mark.parametrize(
    'angles',
    [
        [(0.4, 0.25, -0.3)] * 100,  # 0.99 s
        [(0.4, 0.55, -0.3)] * 300,  # raised to 31.5 deg
        [(0.4, 2.9, -0.3)] * 300,  # upside down
        [(0.4, 0.2, 0.0006 * k) for k in range(300)],  # turns at 0.06 rad/s
        [(0.4, 0.0006 * k, 0.0) for k in range(300)],  # rises at 0.06 rad/s
        swinging(400),
        [],
    ],
)
def test_without_a_still_second_there_is_no_rest(angles: Any) -> None:
    assert find_rest(stamped(angles)).rest is None


def test_slow_drift_is_still() -> None:
    drift = [(0.4, 0.2 + 0.0004 * k, 0.0) for k in range(101)]  # 0.04 rad/s
    rest = find_rest(stamped(drift)).rest
    assert rest is not None
    assert rest.humerus == pytest.approx((0.4, 0.22), abs=1e-9)


@pytest.mark.parametrize('gap', [260_000_000, -1])
def test_a_gap_and_a_fall_of_the_stamps_begin_again(gap: int) -> None:
    still, pose = StillSecond(), {'humerus': HUMERUS.rotation((0.4, 0.2, 0.0))}
    stamps = [k * 10**7 for k in range(90)]
    stamps += [stamps[-1] + gap + k * 10**7 for k in range(101)]
    answers = [still.add(stamp, pose) for stamp in stamps]
    assert answers.index(still.rest) == 190
    assert still.start == stamps[90]


def test_a_stream_of_four_poses_a_second_is_enough() -> None:
    rest = find_rest(stamped([(0.4, 0.2, 0.0)] * 5, rate=4.0)).rest
    assert rest is not None
    assert find_rest(stamped([(0.4, 0.2, 0.0)] * 9, rate=3.9)).rest is None


def test_a_scapula_that_moves_is_not_at_rest_though_the_arm_hangs() -> None:
    def poses() -> Poses:
        for stamp, bones in stamped([(0.4, 0.2, 0.0)] * 300):
            up = min(0.004 * stamp / 1e7, 0.3)
            yield stamp, {**bones, 'scapula': GIRDLE.rotation((0.5, up, -0.1))}

    found = find_rest(poses())
    assert found.rest is not None
    assert found.rest.scapula == pytest.approx((0.5, 0.3, -0.1), abs=0.05)
    assert found.start > 60 * 10**7
    assert found.rest.clavicle == Rest().clavicle


@pytest.mark.parametrize('plane', [-2.5, 0.0, 0.6, 3.0])
def test_an_arm_straight_down_has_the_plane_of_the_scapula(plane: float) -> None:
    rest = find_rest(stamped([(plane, 0.03, -plane)] * 101)).rest
    assert rest is not None
    assert rest.humerus == pytest.approx((np.pi / 6, 0.03), abs=1e-9)
    # there the regression gives an average subject his own rest, to a few deg in each angle
    own = RHYTHMS['de_groot_brand_2001'].bones((np.pi / 6, 0.2, 0.0))['scapula'][0]
    assert np.degrees(GIRDLE.angles(own)) == pytest.approx(np.degrees(Rest().scapula), abs=4.0)
    leaning = find_rest(stamped([(plane, 0.1, 0.2)] * 101)).rest
    assert leaning is not None
    assert leaning.humerus == pytest.approx((plane, 0.1), abs=1e-9)


@requires('rosbags')
def test_the_recorded_abduction_begins_at_rest(shared: Path) -> None:
    poses = girdle_poses(shared / 'recordings' / 'girdle_abduction_mcap')
    by_frame = [{bone: R[k] for bone, (R, _) in poses.items()} for k in range(101)]
    found = find_rest((k * 10**7, bones) for k, bones in enumerate(by_frame))
    assert found.start == 0
    assert found.rest is not None
    for bone, angles in (('scapula', found.rest.scapula), ('clavicle', found.rest.clavicle)):
        mean = Rotation.from_matrix(poses[bone][0][:101]).mean().as_matrix()
        np.testing.assert_allclose(GIRDLE.rotation(angles), mean, rtol=0, atol=1e-6)
    alone = find_rest((k * 10**7, {'humerus': each['humerus']}) for k, each in enumerate(by_frame))
    assert alone.rest is not None
    assert alone.rest.humerus == found.rest.humerus


@requires('rosbags')
def test_in_the_recorded_shrug_arm_and_scapula_are_still_only_after_it(shared: Path) -> None:
    poses = girdle_poses(shared / 'recordings' / 'girdle_shrug_mcap')
    count = len(poses['humerus'][0])
    found = find_rest(
        (k * 10**7, {bone: R[k] for bone, (R, _) in poses.items()}) for k in range(count)
    )
    assert found.rest is not None
    assert found.start > 2.5e9


def test_what_is_no_rotation_is_refused() -> None:
    with pytest.raises(LinkedPlaneError, match=r'^rotation'):
        StillSecond().add(0, {'humerus': np.zeros((3, 3))})
