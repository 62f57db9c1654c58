"""What the page of conventions says is so: its examples are run, its tables computed anew."""

from __future__ import annotations

import doctest
import re
from pathlib import Path

import numpy as np
import pytest

from linkedplane_ros import JOINT_CONVENTIONS

TOP = Path(__file__).parents[2]
PAGE = (TOP / 'doc' / 'explanation' / 'conventions.md').read_text()
ELBOW, FOREARM = np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0])


def table(name: str) -> list[str]:
    """Return the lines of a table of the page."""
    return PAGE.partition(f'<!-- {name} -->\n')[2].partition('\n<!-- /')[0].splitlines()


def direction(R: np.ndarray, vector: np.ndarray) -> str:
    """Return a turned vector as the tables have it."""
    return ', '.join(f'{value:.3f}' for value in np.round(R @ vector, 3) + 0.0)


def test_every_example_prints_what_the_page_says() -> None:
    blocks = list(re.finditer(r'^```python\n(.*?)^```$', PAGE, re.MULTILINE | re.DOTALL))
    runner = doctest.DocTestRunner(verbose=False)
    names: dict[str, object] = {}
    told: list[str] = []
    with np.printoptions():
        for block in blocks:
            line = PAGE[: block.start()].count('\n') + 1
            test = doctest.DocTestParser().get_doctest(
                block[1], names, 'conventions.md', 'doc/explanation/conventions.md', line
            )
            runner.run(test, out=told.append, clear_globs=False)
            names = test.globs
    assert not told, ''.join(told)
    assert runner.tries > 100


def test_the_table_of_conventions_is_that_of_the_code() -> None:
    lines = [
        '| convention | coordinates | rotation | usually against |',
        '| --- | --- | --- | --- |',
    ]
    for name, convention in JOINT_CONVENTIONS.items():
        coordinates = ', '.join(convention.coordinates)
        against = convention.relative_to
        lines.append(f'| `{name}` | {coordinates} | {convention.formula} | {against} |')
    assert table('conventions') == lines


def test_each_angle_alone_takes_the_arm_where_the_table_says() -> None:
    lines = ['| convention | +30 deg of | elbow | forearm |', '| --- | --- | --- | --- |']
    for name, convention in JOINT_CONVENTIONS.items():
        for j, coordinate in enumerate(convention.coordinates):
            R = convention.rotation(np.radians(30.0) * np.eye(3)[j])
            first = ' ' if j else f' `{name}` '
            elbow, forearm = direction(R, ELBOW), direction(R, FOREARM)
            lines.append(f'|{first}| {coordinate} | {elbow} | {forearm} |')
    assert table('single angles') == lines


def test_three_angles_at_once_take_the_arm_where_the_table_says() -> None:
    lines = ['| convention | elbow | forearm |', '| --- | --- | --- |']
    for name, convention in JOINT_CONVENTIONS.items():
        R = convention.rotation(np.radians([30.0, 60.0, 20.0]))
        lines.append(f'| `{name}` | {direction(R, ELBOW)} | {direction(R, FOREARM)} |')
    assert table('three angles') == lines


def test_all_conventions_are_at_zero_where_the_frames_coincide() -> None:
    for convention in JOINT_CONVENTIONS.values():
        np.testing.assert_array_equal(convention.rotation([0.0, 0.0, 0.0]), np.eye(3))


def test_mujoco_has_w_first() -> None:
    mujoco = pytest.importorskip('mujoco', reason='mujoco is not installed: nothing to compare')
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.eye(3).ravel())
    np.testing.assert_array_equal(quaternion, [1.0, 0.0, 0.0, 0.0])
