"""What the page of conventions says is so: its examples are run."""

from __future__ import annotations

import doctest
import re
from pathlib import Path

import numpy as np
import pytest

from linkedplane_ros import JOINT_CONVENTIONS

TOP = Path(__file__).parents[2]
PAGE = (TOP / 'doc' / 'explanation' / 'conventions.md').read_text()


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


def test_all_conventions_are_at_zero_where_the_frames_coincide() -> None:
    for convention in JOINT_CONVENTIONS.values():
        np.testing.assert_array_equal(convention.rotation([0.0, 0.0, 0.0]), np.eye(3))


def test_mujoco_has_w_first() -> None:
    mujoco = pytest.importorskip('mujoco', reason='mujoco is not installed: nothing to compare')
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.eye(3).ravel())
    np.testing.assert_array_equal(quaternion, [1.0, 0.0, 0.0, 0.0])
