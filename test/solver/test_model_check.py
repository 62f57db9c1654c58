# SPDX-License-Identifier: Apache-2.0
"""What will hurt in a model: found over its range of motion, named by band and pose, and drawn."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import reference
from reference import Array

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.commands.main import main
from linkedplane_ros.solver import range_check
from linkedplane_ros.solver.interference import depths
from linkedplane_ros.solver.range_check import DEFAULT_RANGE, check_model
from linkedplane_ros.solver.report import model_report

DELTOID = BroadMuscle.load('deltoid')
BONELESS = replace(
    DELTOID,
    interference_names=(),
    interference_centres=np.empty((0, 3)),
    interference_radii=np.empty(0),
)
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
SMALL = ((0.0, 1.0), (0.0, 1.0), (0.0, 0.0))  # rad: 9 x 7 x 1 poses


def rotations(limits: tuple[tuple[float, float], ...]) -> Array:
    """Return the poses (m, 3, 3) that a model of this range is looked at."""
    axes = [np.unique(np.linspace(*span, n)) for span, n in zip(limits, (9, 7, 5), strict=True)]
    return np.array([THESIS.rotation((f, a, r)) for f in axes[0] for a in axes[1] for r in axes[2]])


def test_but_for_the_bones_the_published_deltoid_has_nothing_to_warn_of() -> None:
    look = check_model(BONELESS)
    assert look.warnings == ()
    assert look.poses == 9 * 7 * 5
    assert look.range_of_motion == DELTOID.range_of_motion


def test_a_jump_is_searched_for_only_where_moment_arms_do_not_predict_the_change(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    solved, searched = range_check.solve_lengths, []

    def count(solver: LinkedPlaneSolver, *angles: Array) -> Array:
        searched.append(len(angles[0]))
        return solved(solver, *angles)

    monkeypatch.setattr(range_check, 'solve_lengths', count)
    check_model(BONELESS)
    assert len(searched) == range_check.HALVINGS + 1
    assert max(searched) < 0.05 * 3 * 315  # of about three pairs for each pose


def test_bands_that_enter_bone_are_told_with_their_depth() -> None:
    still = replace(DELTOID, range_of_motion=((0.0, 0.0),) * 3)
    state = LinkedPlaneSolver(DELTOID).solve(np.eye(3))
    deep = 1e3 * depths(state)[0].max(axis=1)
    expected = [
        f'{band}: it enters bone, by up to {d:.1f} mm '
        '(flexion 0, abduction 0, rotation 0 deg); at 1 of 1 poses'
        for band, d in zip(DELTOID.band_names, deep, strict=True)
        if d > 0.0
    ]
    assert check_model(still).warnings == tuple(expected)
    assert len(expected) == 2


def test_a_model_that_states_no_range_is_looked_at_over_the_deltoids() -> None:
    np.testing.assert_allclose(DEFAULT_RANGE, DELTOID.range_of_motion, atol=1e-6)  # rad, as printed
    assert check_model(replace(DELTOID, range_of_motion=None)).range_of_motion == DEFAULT_RANGE


@pytest.mark.parametrize(('end', 'centre'), [('origin', 'origins'), ('insertion', 'insertions')])
def test_an_attachment_inside_its_sphere_is_told_with_its_depth(end: str, centre: str) -> None:
    # spheres on the bone of the attachment, 5 mm off it: as deep at all poses
    radii = np.full(9, 0.004)
    radii[3] = 0.0075
    muscle = replace(
        BONELESS,
        sphere_frame={'origin': 'ground', 'insertion': 'humerus'}[end],
        sphere_centres=getattr(DELTOID, centre) + np.array([0.0, 0.005, 0.0]),
        sphere_radii=radii,
        range_of_motion=SMALL,
    )
    [line] = check_model(muscle).warnings
    assert line.startswith(
        f'middle_1: its {end} lies inside its obstacle sphere, up to 2.5 mm deep (flexion '
    )
    assert line.endswith('at 63 of 63 poses')


def test_the_worst_pose_of_an_attachment_in_a_moving_sphere_is_told() -> None:
    radii = DELTOID.sphere_radii * 2.2
    muscle = replace(BONELESS, sphere_radii=radii)
    poses = rotations(muscle.range_of_motion)
    centres = reference.sphere_centres(muscle, poses)
    ends = np.einsum('mij,nj->mni', poses, muscle.insertions)
    depths = 1e3 * (radii - np.linalg.norm(ends - centres, axis=2))
    told = {
        line.split(':')[0]: line for line in check_model(muscle).warnings if 'insertion' in line
    }
    inside = (depths > 0.0).any(axis=0)
    assert set(told) == {name for name, it in zip(muscle.band_names, inside, strict=True) if it}
    assert 2 < len(told) < 9
    for name, line in told.items():
        i = muscle.band_names.index(name)
        assert f'up to {depths[:, i].max():.1f} mm deep' in line
        assert line.endswith(f'at {(depths[:, i] > 0.0).sum()} of 315 poses')
        flexion, abduction, rotation = map(
            int, re.findall(r'-?\d+(?=[, ] ?)', line.split('(')[1])[:3]
        )
        worst = THESIS.rotation(np.radians((flexion, abduction, rotation)))
        k = int(depths[:, i].argmax())
        np.testing.assert_allclose(worst, poses[k], atol=0.01)  # whole degrees are told


def test_a_normal_nearly_along_the_first_band_is_told() -> None:
    line = DELTOID.insertions[0] - DELTOID.origins[0]
    near = reference.unit(line) + 0.05 * DELTOID.reference_normal  # 3 deg off, the arm at the side
    muscle = replace(BONELESS, reference_normal=near, range_of_motion=((0.0, 0.0),) * 3)
    [told] = check_model(muscle).warnings
    sine = np.linalg.norm(np.cross(reference.unit(near), reference.unit(line)))
    off = np.degrees(np.arcsin(sine))
    assert told == (
        f'anterior_1: its plane follows a normal that runs within {off:.1f} deg of its line '
        '(flexion 0, abduction 0, rotation 0 deg); at 1 of 1 poses'
    )


def test_a_plane_angle_that_turns_the_fan_over_is_told() -> None:
    phi = DELTOID.plane_angles.copy()
    phi[4] = np.radians(130.0)
    muscle = replace(BONELESS, plane_angles=phi, range_of_motion=SMALL)
    [told] = [line for line in check_model(muscle).warnings if 'turns the fan over' in line]
    assert told.startswith('middle_2: its plane angle turns the fan over: it bulges up to 1')
    assert 'away from the band before' in told
    chains = [
        reference.chain(muscle, rotation, LinkedPlaneSolver(muscle).solve(rotation).theta)
        for rotation in rotations(SMALL)
    ]
    sides = []
    for rotation, chain in zip(rotations(SMALL), chains, strict=True):
        u = reference.unit(muscle.insertions @ rotation.T - muscle.origins)
        e = [np.cross(u[i], chain[i].normal) for i in (3, 4)]
        sides.append(np.degrees(np.arccos(e[0] @ e[1])))
    assert f'up to {max(sides):.0f} deg away' in told


def test_a_length_that_jumps_is_told_with_how_far() -> None:
    # where the last bands' lines pass the middle of the ball, the fan goes round it either way
    muscle = replace(
        BroadMuscle.load('example_shared_sphere'),
        sphere_radii=np.full(5, 0.031),
        plane_angles=np.radians(np.full(5, 62.0)),
        range_of_motion=((-0.4, 1.6), (0.0, 1.0), (-0.8, 0.8)),
    )
    told = [line for line in check_model(muscle).warnings if 'its length jumps' in line]
    match = re.fullmatch(
        r'(\w+): its length jumps, by up to ([\d.]+) mm \(flexion (\S+), abduction (\S+), '
        r'rotation (\S+) deg\); between [1-9]\d* of 802 pairs of neighbouring poses',
        told[-1],
    )
    assert match
    name, size, *pose = match.groups()
    # within the rounding of the pose that is told, along one of the coordinates
    ways = np.radians(np.linspace(-1.0, 1.0, 801))[:, np.newaxis, np.newaxis] * np.eye(3)
    angles = np.radians([float(angle) for angle in pose]) + ways
    rotations, _ = THESIS.rotations_and_axes(angles.reshape(-1, 3))
    lengths = LinkedPlaneSolver(muscle).solve_batch(rotations).lengths.reshape(801, 3, -1)
    leaps = np.abs(np.diff(lengths[..., muscle.band_names.index(name)], axis=0))
    assert 1e3 * leaps.max() == pytest.approx(float(size), abs=1.0)  # mm: it grows over the degree


def test_poses_at_which_a_band_has_no_plane_are_told() -> None:
    # at one pose of the grid the humerus has a band's insertion at its origin
    pose = np.radians((80.0, 60.0, 0.0))
    insertions = DELTOID.insertions.copy()
    insertions[2] = THESIS.rotation(pose).T @ DELTOID.origins[2]
    muscle = replace(BONELESS, insertions=insertions, range_of_motion=DEFAULT_RANGE)
    told = check_model(muscle).warnings[0]
    assert told.startswith('band anterior_3 has no plane at this pose')
    assert told.endswith('(flexion 80, abduction 60, rotation 0 deg); at 1 of 315 poses')


def test_info_prints_the_warnings_and_ends_well(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / 'large.yaml'
    replace(BONELESS, sphere_radii=DELTOID.sphere_radii * 2.2).to_yaml(path)
    assert main(['info', str(path)]) == 0
    out, err = capsys.readouterr()
    assert err == ''
    lines = [line for line in out.splitlines() if line.startswith('warning: ')]
    look = check_model(BroadMuscle.load(path))
    assert lines == [f'warning: {line}' for line in look.warnings]
    assert f'315 poses checked, {len(lines)} warnings' in out


def test_info_tells_what_the_spheres_move_with() -> None:
    shared = replace(
        BONELESS,
        sphere_frame=('ground',) * 4 + ('humerus',) * 4 + ('moving',),
        sphere_centres=np.tile([0.0, 0.001, 0.002], (9, 1)),
        sphere_radii=np.full(9, 0.02),
        licence='',
    )
    lines = list(model_report(shared))
    assert 'licence: not stated' in lines
    assert '1 obstacle sphere on the scapula, for 4 bands' in lines
    assert '1 obstacle sphere on the humerus, for 4 bands' in lines
    assert "1 obstacle sphere in their bands' moving frames, for 1 band" in lines
    lines = list(model_report(DELTOID))
    assert "9 obstacle spheres in their bands' moving frames, for 9 bands" in lines


@pytest.mark.parametrize('name', ['deltoid', 'deltoid_girdle'])
def test_info_prints_every_band_with_the_arm_at_the_side(name: str) -> None:
    muscle = BroadMuscle.load(name)
    lines = list(model_report(muscle))
    start = next(k for k, line in enumerate(lines) if line.startswith('band '))
    assert ' insertion (humerus) ' in lines[start]
    assert (' origin (scapula) ' in lines[start]) == (name == 'deltoid')
    assert ('origin (' in lines[start]) == (name == 'deltoid')  # the girdle's are on two bones
    theta = reference.neutral_theta(DELTOID)
    paths = reference.chain(DELTOID, np.eye(3), theta)
    for i, path in enumerate(paths):
        band, head, *numbers, wrap = lines[start + 1 + i].split()
        phi = numbers.pop(7)
        assert (band, head) == (DELTOID.band_names[i], band.split('_')[0])
        assert wrap == ('wrapped' if path.state == reference.WRAPPED else 'clear')
        assert phi == 'theta' if i == 0 else float(phi) == round(DELTOID.plane_angles[i], 3)
        sizes = np.array([DELTOID.sphere_radii[i], path.length])
        want = 1e3 * np.concatenate((DELTOID.origins[i], DELTOID.insertions[i], sizes))
        np.testing.assert_allclose(np.array(numbers, float), want, rtol=0.0, atol=0.0501)  # mm
    found = re.search(r'arm at the side: theta (\S+) rad, total (\S+) mm', '\n'.join(lines))
    assert found
    assert float(found[1]) == pytest.approx(theta, abs=1e-6)
    assert float(found[2]) == pytest.approx(1e3 * sum(one.length for one in paths), abs=1e-3)


def test_info_prints_the_line_for_an_editor(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['info', '--schema']) == 0
    mark, path = capsys.readouterr().out.strip().split('$schema=')
    assert mark == '# yaml-language-server: '
    assert Path(path).read_text().startswith('{')
