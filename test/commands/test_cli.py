# SPDX-License-Identifier: Apache-2.0
"""The command line: what `info` and `solve` print."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import command_fault, command_output

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, WrapState

THESIS = 'flexion_abduction_rotation'
DELTOID = BroadMuscle.load('deltoid')
RIGHT = LinkedPlaneSolver(DELTOID)
MODEL = (Path(__file__).parents[2] / 'linkedplane_ros' / 'models' / 'deltoid.yaml').read_text()
SHOWN = 0.5e-3  # mm: three decimals are printed


def solved(convention: str, angles: tuple[float, ...], side: str = 'right') -> tuple[Any, Any]:
    """Return the solver's state and moment arms."""
    chosen = JOINT_CONVENTIONS[convention]
    state = LinkedPlaneSolver(DELTOID, side).solve(chosen.rotation(angles))
    return state, state.moment_vectors @ chosen.axes(angles, side)


def rows(text: str) -> dict[str, list[str]]:
    """Return the words of each band's row."""
    lines = [line.split() for line in text.splitlines()]
    return {words[0]: words[1:] for words in lines if words and words[0] in DELTOID.band_names}


def test_info_shows_every_band_with_its_ends_its_sphere_and_its_length(
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = command_output(capsys, 'info')
    assert command_output(capsys, 'info', 'deltoid') == text
    assert text.startswith('deltoid: 9 bands, 3 heads\n')
    assert DELTOID.source in text
    state = RIGHT.solve(np.eye(3))
    assert f'theta {state.theta:.6f} rad, total {1e3 * state.total_length:.3f} mm' in text
    found = rows(text)
    assert tuple(found) == DELTOID.band_names
    for i, (band, (head, *words, wrap)) in enumerate(found.items()):
        assert head == DELTOID.find_head(band)
        assert wrap == WrapState(state.wrap[i]).name.lower()
        numbers = [float('nan') if word == 'theta' else float(word) for word in words]
        ends = 1e3 * np.concatenate((DELTOID.origins[i], DELTOID.insertions[i]))
        # one decimal is printed
        np.testing.assert_allclose(numbers[:6], ends, rtol=0.0, atol=0.0501)
        assert numbers[6] == pytest.approx(1e3 * DELTOID.sphere_radii[i], abs=0.0501)
        assert numbers[8] == pytest.approx(1e3 * state.lengths[i], abs=0.0501)
        if i:
            assert numbers[7] == pytest.approx(DELTOID.plane_angles[i], abs=0.000501)
    assert found['anterior_1'][8] == 'theta'
    for head in DELTOID.heads:
        assert f'{head.name}: {", ".join(head.bands)}; represented by {head.represented_by}' in text


def test_info_takes_a_model_file(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / 'mine.yaml'
    path.write_text(MODEL.replace('name: deltoid', 'name: mine'))
    assert command_output(capsys, 'info', path).startswith('mine: 9 bands, 3 heads\n')


@pytest.mark.parametrize('side', ['right', 'left'])
@pytest.mark.parametrize('convention', JOINT_CONVENTIONS)
def test_json_holds_what_the_solver_gives_to_the_bit(
    capsys: pytest.CaptureFixture[str], convention: str, side: str
) -> None:
    angles = (0.3, 0.8, -0.2)
    text = command_output(
        capsys, 'solve', '--json', '--side', side, '--convention', convention, *angles
    )
    state, arms = solved(convention, angles, side)
    assert json.loads(text) == {
        'muscle': 'deltoid',
        'side': side,
        'convention': convention,
        'coordinates': list(JOINT_CONVENTIONS[convention].coordinates),
        'angles_rad': list(angles),
        'theta_rad': state.theta,
        'bands': list(DELTOID.band_names),
        'lengths_m': state.lengths.tolist(),
        'moment_arms_m': arms.tolist(),
        'moment_vectors_m': state.moment_vectors.tolist(),
        'wrap': [WrapState(wrap).name for wrap in state.wrap],
    }


def test_the_table_holds_what_the_solver_gives_in_mm(capsys: pytest.CaptureFixture[str]) -> None:
    text = command_output(capsys, 'solve', '--convention', THESIS, '0.3', '0.8', '-0.2')
    state, arms = solved(THESIS, (0.3, 0.8, -0.2))
    for i, (length, *moment_arms, wrap) in enumerate(rows(text).values()):
        assert float(length) == pytest.approx(1e3 * state.lengths[i], abs=1.01 * SHOWN)
        shown = [float(word) for word in moment_arms]
        np.testing.assert_allclose(shown, 1e3 * arms[i], rtol=0.0, atol=1.01 * SHOWN)
        assert wrap == WrapState(state.wrap[i]).name.lower()
    assert len(rows(text)) == 9
    assert f'total {1e3 * state.total_length:.3f} mm, theta {state.theta:.6f} rad' in text
    assert JOINT_CONVENTIONS[THESIS].formula in text
    assert 'flexion 17.19 deg, abduction 45.84 deg, rotation -11.46 deg' in text


def test_degrees_are_turned_into_radians(capsys: pytest.CaptureFixture[str]) -> None:
    text = command_output(
        capsys, 'solve', '--json', '--degrees', '--convention', THESIS, '10', '90', '-20'
    )
    answer = json.loads(text)
    angles = tuple(np.radians((10.0, 90.0, -20.0)).tolist())
    assert answer['angles_rad'] == pytest.approx(angles, abs=1e-15)
    assert answer['lengths_m'] == pytest.approx(solved(THESIS, angles)[0].lengths, abs=1e-12)


@pytest.mark.parametrize('convention', JOINT_CONVENTIONS)
def test_the_left_shoulder_has_the_moment_arms_of_the_right(
    capsys: pytest.CaptureFixture[str], convention: str
) -> None:
    right, left = (
        json.loads(
            command_output(capsys, 'solve', '--json', '--side', side, '--convention', convention,
                 '0.3', '0.8', '-0.2')
        )
        for side in ('right', 'left')
    )  # fmt: skip
    assert left['lengths_m'] == pytest.approx(right['lengths_m'], abs=1e-12)
    for one, other in zip(left['moment_arms_m'], right['moment_arms_m'], strict=True):
        assert one == pytest.approx(other, abs=1e-12)


@pytest.mark.parametrize('angle', ['-0.5', '-.5', '-1', '-0', '1e-3', '-1e-3', '-2.5E-1'])
def test_an_angle_may_be_written_in_any_usual_way(
    capsys: pytest.CaptureFixture[str], angle: str
) -> None:
    text = command_output(capsys, 'solve', '--json', '--convention', THESIS, angle, '0', angle)
    assert json.loads(text)['angles_rad'] == [float(angle), 0.0, float(angle)]


@pytest.mark.parametrize(
    ('angles', 'reason'),
    [
        (('0', '90', '0'), '90 rad is more than a full turn; --degrees?'),
        (('-7', '0', '0'), '7 rad is more than a full turn; --degrees?'),
        (('inf', '0', '0'), 'inf rad'),
        (('nan', '0', '0'), 'angles: [nan, 0.0, 0.0] given, 3 finite numbers in rad expected'),
        (('0', '90', 'nan'), ''),
        (('--degrees', '0', '1e400', '0'), '3 finite numbers in rad expected'),
    ],
)
def test_angles_that_are_none_are_refused_in_one_line(
    capsys: pytest.CaptureFixture[str], angles: tuple[str, ...], reason: str
) -> None:
    assert reason in command_fault(capsys, 'solve', '--convention', THESIS, *angles)
