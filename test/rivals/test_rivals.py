"""The rivals' paths: lengths, moments and wrap states, against MuJoCo and by hand."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from random_bands import BONES, MODELS, Model, many, one, rotations, slopes, turned
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import WrapState
from linkedplane_ros.linked_planes.compiled import COMPILED
from linkedplane_ros.rivals import (
    Bands,
    CappedCylinder,
    Cylinder,
    DoubleCylinder,
    PathModel,
    PathState,
    Sphere,
    Straight,
    ViaPoints,
)

STILL = np.eye(3)
every_model = pytest.mark.parametrize('kind', MODELS, ids=lambda kind: kind.__name__)
every_obstacle = pytest.mark.parametrize('kind', MODELS[2:], ids=lambda kind: kind.__name__)


# What each path is, by hand


def test_a_straight_band_is_the_line() -> None:
    state = Straight((0.0, 0.0, 0.0), (0.0, 0.0, -0.1)).solve(STILL)
    assert (state.length, state.wrap) == (0.1, WrapState.CLEAR)
    np.testing.assert_array_equal(state.path(), [(0, 0, 0), (0, 0, -0.1)])


def test_via_points_are_passed_in_order_and_move_with_their_bones() -> None:
    band = ViaPoints((0, 0, 0), (0.1, 0, 0), ((0, 0, 0.05),), ((0.1, 0, 0.05),))
    state = band.solve(Rotation.from_rotvec((np.pi, 0, 0)).as_matrix())
    points = [(0, 0, 0), (0, 0, 0.05), (0.1, 0, -0.05), (0.1, 0, 0)]
    np.testing.assert_allclose(state.path(), points, rtol=0, atol=1e-15)  # m: rounding
    assert state.length == pytest.approx(0.1 + np.hypot(0.1, 0.1), abs=1e-15)  # m: rounding


def quarter(kind: Model, **more: Any) -> PathModel:
    """Return a band with a quarter of a turn about z, right-handed, at a radius of 0.03 m."""
    return kind((0.03, -0.01, 0.0), (-0.01, 0.03, 0.0), (0, 0, 0), radius=0.03, **more)


@pytest.mark.parametrize('bone', BONES)
def test_a_quarter_round_a_sphere_and_round_a_cylinder_is_the_same(bone: str) -> None:
    length = 0.02 + 0.03 * np.pi / 2
    for band in (
        quarter(Sphere, bone=bone),
        quarter(Cylinder, axis=(0, 0, 2), bone=bone),
        quarter(CappedCylinder, axis=(0, 0, 2), bone=bone),
        quarter(CappedCylinder, axis=(0, 0, -2), bone=bone, turn='left-handed'),
    ):
        state = band.solve(STILL)
        assert state.wrap == WrapState.WRAPPED
        assert state.length == pytest.approx(length, abs=1e-15)  # m: rounding
        # it pulls the humerus back, left-handed
        np.testing.assert_allclose(state.moment_vector, (0, 0, -0.03), rtol=0, atol=1e-15)


def test_a_band_on_a_cylinder_is_a_straight_line_when_unrolled() -> None:
    band = Cylinder((0.03, -0.04, 0), (-0.04, 0.03, 0.06), (0, 0, 9), (0, 0, 1), 0.03, 'scapula')
    state = band.solve(STILL)
    flat = 0.08 + 0.03 * np.pi / 2
    assert state.length == pytest.approx(np.hypot(flat, 0.06), abs=1e-15)  # m: rounding
    path = state.path(9)
    on_cylinder = path[1:-1]
    np.testing.assert_allclose(np.hypot(*on_cylinder[:, :2].T), 0.03, rtol=0, atol=1e-15)
    steps = np.diff(on_cylinder, axis=0)
    np.testing.assert_allclose(steps[:, 2], steps[0, 2], rtol=0, atol=1e-15)


def test_the_axis_says_on_which_side_a_cylinder_is_passed() -> None:
    band = Cylinder((0.1, 0.01, 0), (-0.1, 0.01, 0), (0, 0, 0), (0, 0, 1), 0.03, 'scapula')
    other = replace(band, axis=(0, 0, -1))
    assert band.solve(STILL).path()[5, 1] > 0.0 > other.solve(STILL).path()[5, 1]
    assert band.solve(STILL).length < other.solve(STILL).length


def hooked(y: float) -> Cylinder:
    """Return a band whose line passes a cylinder of radius 0.03 at -y; its side is that of +y."""
    return Cylinder((0.1, -y, 0), (-0.1, -y, 0), (0, 0, 0), (0, 0, 1), 0.03, 'scapula')


def test_a_line_on_the_wrong_side_is_hooked_round_a_cylinder_up_to_half_a_turn() -> None:
    assert hooked(0.04).solve(STILL).wrap == WrapState.WRAPPED
    assert hooked(-0.04).solve(STILL).wrap == WrapState.CLEAR
    # half a turn is where both tangents are parallel: the ends as far from the axis as the surface
    near = replace(hooked(0.1), origin=(0.03 + 1e-9, -0.1, 0), insertion=(-0.03 - 1e-9, -0.1, 0))
    state = near.solve(STILL)
    assert state.wrap == WrapState.WRAPPED
    assert state.length == pytest.approx(0.2 + 0.03 * np.pi, abs=1e-8)  # m: as near as the ends


def test_beyond_half_a_turn_the_band_is_straight_and_missed() -> None:
    beyond = replace(hooked(0.1), origin=(0.03 - 1e-9, -0.1, 0), insertion=(-0.03 + 1e-9, -0.1, 0))
    state = beyond.solve(STILL)
    assert state.wrap == WrapState.MISSED
    assert state.length == pytest.approx(0.06, abs=1e-8)  # m: as near as the ends


def test_a_sphere_is_passed_on_the_short_side_and_left_when_the_line_keeps_off() -> None:
    for z, wrap in ((0.01, 0), (-0.01, 0), (0.0301, 1)):
        band = Sphere((0.1, 0, z), (-0.1, 0, z), (0, 0, 0), 0.03, 'scapula')
        state = band.solve(STILL)
        assert state.wrap == wrap
        assert (state.path()[1:-1, 2] * z >= 0.0).all()


def test_a_line_through_the_centre_of_a_sphere_has_a_path() -> None:
    for end in np.eye(3):
        P, S = tuple((0.1 * end).tolist()), tuple((-0.08 * end).tolist())
        state = Sphere(P, S, (0, 0, 0), 0.03, 'scapula').solve(STILL)
        flat = np.sqrt(0.1**2 - 0.03**2) + np.sqrt(0.08**2 - 0.03**2)
        turn = np.arcsin(0.03 / 0.1) + np.arcsin(0.03 / 0.08)
        assert state.length == pytest.approx(flat + 0.03 * turn, abs=1e-15)  # m: rounding
        assert np.isfinite(state.moment_vector).all()


def test_two_cylinders_are_wrapped_together_one_alone_or_not_at_all() -> None:
    band = DoubleCylinder((-0.1, 0, 0), (0.19, 0, 0), (0, 0, -0.01), (0, 1, 0), 0.03, 'scapula',
                          (0.09, 0, -0.01), (0, 1, 0), 0.03, 'humerus')  # fmt: skip
    off, far = (0, 0, -0.1), (0.09, 0, -0.1)
    for model, contacts in (
        (band, 3),
        (replace(band, second_centre=far), 1),
        (replace(band, centre=off), 2),
        (replace(band, centre=off, second_centre=far), 0),
    ):
        assert model.solve(STILL).contacts == contacts
    alone = Cylinder(band.origin, band.insertion, band.centre, band.axis, 0.03, 'scapula')
    with_far = replace(band, second_centre=far).solve(STILL)
    assert with_far.length == pytest.approx(alone.solve(STILL).length, abs=1e-15)  # m: rounding
    # both: a belt over two circles on a level
    side = np.sqrt(0.1**2 + 0.01**2 - 0.03**2)
    turn = np.arcsin(0.03 / np.hypot(0.1, 0.01)) + np.arctan2(-0.01, 0.1)
    assert band.solve(STILL).length == pytest.approx(2 * (side + 0.03 * turn) + 0.09, abs=1e-14)


def test_a_band_may_cross_from_the_cap_to_the_cylinder() -> None:
    down = CappedCylinder((0.04, -0.01, 0.04), (-0.02, 0.03, -0.03), (0, 0, 0), (0, 0, 1), 0.03,
                          'scapula')  # fmt: skip
    up = replace(down, origin=down.insertion, insertion=down.origin, turn='left-handed')
    there, back = down.solve(STILL), up.solve(STILL)
    assert (there.contacts, back.contacts) == (3, 3)
    assert there.length == pytest.approx(back.length, abs=1e-15)  # m: rounding
    np.testing.assert_allclose(there.path(), back.path()[::-1], rtol=0, atol=1e-15)
    heights = there.path(50)[1:-1, 2]
    assert (np.diff(heights) <= 1e-15).all()
    assert heights.max() > 0.0 > heights.min()


def test_the_shorter_side_of_a_capped_cylinder_is_the_shorter_of_both() -> None:
    models = many(CappedCylinder, 400, seed=5)
    lengths = [
        Bands([replace(model, turn=turn) for model in models]).solve(rotations(1)[0])
        for turn in ('right-handed', 'left-handed', 'shorter')
    ]
    right, left, shorter = lengths
    both = (right.wrap == WrapState.WRAPPED) & (left.wrap == WrapState.WRAPPED)
    least = np.minimum(right.lengths, left.lengths)
    np.testing.assert_array_equal(shorter.lengths[both], least[both])
    assert both.sum() > 30
    assert (np.abs(right.lengths - left.lengths)[both] > 1e-3).sum() > 20
    assert not (shorter.wrap == WrapState.MISSED).any()


@every_obstacle
@pytest.mark.parametrize('end', ['origin', 'insertion'])
def test_an_end_in_its_obstacle_is_inside_and_straight(kind: Model, end: str) -> None:
    second = kind is DoubleCylinder and end == 'insertion'
    for model in many(kind, 50):
        centre = model.second_centre if second else model.centre
        state = replace(model, **{end: centre}).solve(STILL)
        assert (state.wrap, state.contacts) == (WrapState.INSIDE, 0)
        line = np.subtract(state.model.insertion, state.model.origin)
        assert state.length == pytest.approx(np.linalg.norm(line), abs=1e-15)  # m: rounding
        assert len(state.path()) == 2


# What holds for all


@every_model
def test_moment_vectors_are_the_slopes_of_the_length(kind: Model) -> None:
    # Richardson's central differences at two steps; where they differ there is a kink or a jump
    bands = Bands(many(kind, 400))
    R = rotations(1)[0]
    coarse, fine = slopes(bands, R, 2e-4), slopes(bands, R, 1e-4)
    told = np.abs(coarse - fine).max(axis=1) < 1e-9
    state = bands.solve(R)
    off = np.abs(state.moment_vectors + fine).max(axis=1)
    assert told.mean() > 0.97
    assert off[told].max() < 1e-9  # m/rad: the differences' own error is 1e-16 m / 1e-4 rad, h^4
    for contacts in {Straight: (0,), ViaPoints: (0,), DoubleCylinder: (0, 1, 2, 3)}.get(
        kind, (0, 1)
    ):
        assert (told & (state.contacts == contacts)).sum() > 5


@every_model
def test_the_drawn_path_is_as_long_as_the_band_and_bends_nowhere(kind: Model) -> None:
    state = Bands(many(kind, 200)).solve(rotations(1)[0])
    for i, path in enumerate(state.paths(200)):
        parts = np.diff(path, axis=0)
        long = np.linalg.norm(parts, axis=1)
        # m: the polygon of an arc of up to 0.04 m and a turn of pi, in 200 parts
        assert long.sum() == pytest.approx(state.lengths[i], abs=3e-6)
        if kind is ViaPoints or state.contacts[i] == 0:
            continue
        parts, long = parts[long > 1e-6], long[long > 1e-6]
        unit = parts / long[:, np.newaxis]
        # rad: an arc of pi in 200 parts, and shorter parts beside it
        assert np.linalg.norm(np.diff(unit, axis=0), axis=1).max() < 0.04


def below(state: PathState, model: PathModel, R: Array) -> float:
    """Return how deep a path runs in its single obstacle, m; on its surface 0."""
    path = state.path(60)
    centre, axis = np.array(model.centre), np.array(getattr(model, 'axis', (0, 0, 0)))
    bone = R if model.bone == 'humerus' else STILL
    points = np.linspace(path[:-1], path[1:], 9).reshape(-1, 3) - bone @ centre
    if not isinstance(model, Sphere):
        w = bone @ axis / np.linalg.norm(axis)
        height = points @ w
        if isinstance(model, CappedCylinder):
            height = np.minimum(height, 0.0)
        points = points - height[:, np.newaxis] * w
    return float(model.radius - np.linalg.norm(points, axis=1).min())


@pytest.mark.parametrize('kind', [Sphere, Cylinder, CappedCylinder])
def test_a_path_keeps_out_of_its_obstacle(kind: Model) -> None:
    R = rotations(1)[0]
    seen = 0
    for model in many(kind, 300):
        state = model.solve(R)
        if state.wrap in (WrapState.WRAPPED, WrapState.CLEAR):
            seen += state.wrap == WrapState.WRAPPED
            # m: the chord of an arc of up to 0.04 m and pi, in 60 parts, lies 1.4e-5 below it
            assert below(state, model, R) < 1.5e-5
    assert seen > 10


@every_model
def test_a_turn_of_everything_turns_the_moments_and_keeps_the_rest(kind: Model) -> None:
    R, Q = rotations(2)
    models = many(kind, 300)
    here = Bands(models).solve(R)
    there = Bands([turned(model, Q) for model in models]).solve(Q @ R @ Q.T)
    same = here.wrap == there.wrap  # but where rounding decides
    assert same.sum() >= 299
    # m: rounding; a crossing or a second contact is found by a search, so a little more
    np.testing.assert_allclose(here.lengths[same], there.lengths[same], rtol=0, atol=1e-13)
    np.testing.assert_allclose(
        (here.moment_vectors @ Q.T)[same], there.moment_vectors[same], rtol=0, atol=1e-10
    )


@pytest.mark.parametrize('kind', [Straight, Sphere, Cylinder])
def test_seen_from_the_other_bone_a_band_is_the_same(kind: Model) -> None:
    R = rotations(1)[0]
    other = {'scapula': 'humerus', 'humerus': 'scapula'}
    for model in many(kind, 100):
        swapped = {'origin': model.insertion, 'insertion': model.origin}
        if kind is not Straight:
            swapped['bone'] = other[model.bone]
        if kind is Cylinder:
            swapped['axis'] = tuple(-x for x in model.axis)
        here, there = model.solve(R), replace(model, **swapped).solve(R.T)
        assert here.wrap == there.wrap
        assert here.length == pytest.approx(there.length, abs=1e-15)  # m: rounding
        moment = -R @ there.moment_vector
        np.testing.assert_allclose(here.moment_vector, moment, rtol=0, atol=1e-14)


@every_model
def test_a_path_depends_on_its_pose_alone(kind: Model) -> None:
    """To the bit: alone or in a batch, whatever came before, whichever way the band flipped."""
    bands = Bands(many(kind, 30))
    poses = np.concatenate((rotations(300), sweep_over_the_top()))
    order = np.random.default_rng(3).permutation(len(poses))
    ordered, shuffled = bands.solve_batch(poses), bands.solve_batch(poses[order])
    for name in ('lengths', 'moment_vectors', 'wrap', 'contacts'):
        there = getattr(ordered, name)
        assert getattr(shuffled, name).tobytes() == there[order].tobytes()
        single = np.array([getattr(bands.solve(poses[k]), name) for k in order[:50]], there.dtype)
        assert single.tobytes() == there[order[:50]].tobytes()
    assert np.isfinite(ordered.lengths).all()
    assert np.isfinite(ordered.moment_vectors).all()


def sweep_over_the_top() -> Array:
    return Rotation.from_rotvec(np.linspace(0, np.pi, 100)[:, np.newaxis] * (1.0, 0, 0)).as_matrix()


def test_a_band_that_flips_flips_at_the_same_pose_on_the_way_back() -> None:
    """A sphere's band changes sides where its line passes the centre, and has no memory of it."""
    band = Bands([Sphere((0, 0.1, 0), (0, -0.1, -0.001), (0, 0, 0), 0.03, 'scapula')])
    there = sweep_over_the_top()[:30]
    tilted = Rotation.from_rotvec((-0.3, 0, 0)).as_matrix() @ there
    forth, back = band.solve_batch(tilted), band.solve_batch(tilted[::-1])
    np.testing.assert_array_equal(forth.moment_vectors, back.moment_vectors[::-1])
    assert len(np.unique(np.sign(forth.moment_vectors[:, 0, 0]))) == 2
    assert np.abs(np.diff(forth.lengths, axis=0)).max() < 0.0011  # m: 0.03 m times a step of 2 deg


@pytest.mark.skipif(not COMPILED, reason='numba is not installed or LINKEDPLANE_COMPILE is 0')
def test_compiled_and_uncompiled_rivals_agree(tmp_path: Path) -> None:
    code = (
        'import numpy as np\n'
        'from random_bands import MODELS, many, rotations\n'
        'from linkedplane_ros.rivals import Bands\n'
        'found = {}\n'
        'for kind in MODELS:\n'
        '    state = Bands(many(kind, 100, seed=7)).solve_batch(rotations(2))\n'
        '    found[kind.__name__] = state.lengths\n'
        '    found[kind.__name__ + "_"] = state.moment_vectors\n'
        f'np.savez({str(tmp_path / "states.npz")!r}, **found)\n'
    )
    here = str(Path(__file__).parent)
    environment = {
        **os.environ,
        'LINKEDPLANE_COMPILE': '0',
        'PYTHONPATH': os.pathsep.join((here, *sys.path[1:])),
    }
    subprocess.run([sys.executable, '-c', code], env=environment, check=True)
    uncompiled = np.load(tmp_path / 'states.npz')
    for kind in MODELS:
        state = Bands(many(kind, 100, seed=7)).solve_batch(rotations(2))
        near = np.abs(state.lengths - uncompiled[kind.__name__]) < 1e-12  # m: rounding
        assert near.mean() > 0.99  # two cylinders in each other may settle by a hair
        off = np.abs(state.moment_vectors - uncompiled[kind.__name__ + '_'])[near]
        assert off.max() < 1e-9  # m: what a contact found to 1e-12 of the radius leaves


@pytest.mark.skipif(not COMPILED, reason='numba is not installed or LINKEDPLANE_COMPILE is 0')
def test_the_rivals_make_no_kernel_of_the_solver_compile_anew() -> None:
    """Kernels are kept under the state of the sources that were loaded before them."""
    orders = ('linkedplane_ros.solver.kernels', 'linkedplane_ros.rivals.sphere')
    states = set()
    for first in orders:
        code = f'import {first}, linkedplane_ros.solver.kernels as k; print(k._sources)'
        run = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
        assert run.returncode == 0, run.stderr
        states.add(run.stdout)
    assert len(states) == 1


# Against MuJoCo


def mujoco_paths(models: list[PathModel], sides: Array | None) -> Any:
    """Return MuJoCo's tendons of single spheres or cylinders; sides (n, 3), in the bone's frame."""
    pytest.importorskip('mujoco', reason='mujoco is not installed: no rival to compare with')
    import mujoco
    import rivals

    bodies: dict[str, list[str]] = {'scapula': [], 'humerus': []}
    tendons = []
    for i, model in enumerate(models):
        kind = 'cylinder' if isinstance(model, Cylinder) else 'sphere'
        axis = f'zaxis="{rivals.spaced(model.axis)}"' if isinstance(model, Cylinder) else ''
        bodies['scapula'].append(f'<site name="p{i}" pos="{rivals.spaced(model.origin)}"/>')
        bodies['humerus'].append(f'<site name="s{i}" pos="{rivals.spaced(model.insertion)}"/>')
        bodies[model.bone].append(
            f'<geom name="g{i}" type="{kind}" size="{model.radius:.17g} 0.01" {axis} '
            f'pos="{rivals.spaced(model.centre)}" mass="0" contype="0" conaffinity="0"/>'
        )
        side = ''
        if sides is not None:
            bodies[model.bone].append(f'<site name="o{i}" pos="{rivals.spaced(sides[i])}"/>')
            side = f'sidesite="o{i}"'
        tendons.append(
            f'<spatial><site site="p{i}"/><geom geom="g{i}" {side}/><site site="s{i}"/></spatial>'
        )

    class Paths(rivals.MujocoBands):
        def __init__(self) -> None:
            self._mujoco = mujoco
            self._model = mujoco.MjModel.from_xml_string(
                f'<mujoco><worldbody>{"".join(bodies["scapula"])}<body><joint type="ball"/>'
                '<geom type="sphere" size="0.01" mass="1" contype="0" conaffinity="0"/>'
                f'{"".join(bodies["humerus"])}</body></worldbody>'
                f'<tendon>{"".join(tendons)}</tendon></mujoco>'
            )
            self._data = mujoco.MjData(self._model)

    return Paths()


def beside(model: PathModel, R: Array) -> bool:
    """Return whether the obstacle is beside the line, not beyond one of its ends."""
    bone = R if model.bone == 'humerus' else STILL
    line = R @ model.insertion - model.origin
    off = bone @ model.centre - model.origin
    if isinstance(model, Cylinder):
        w = bone @ model.axis / np.linalg.norm(model.axis)
        line, off = line - (line @ w) * w, off - (off @ w) * w
    return bool(0.0 < off @ line < line @ line)


def check_against_mujoco(models: list[PathModel], sides: Array | None, R: Array) -> Array:
    """Compare lengths and moments where both have the rule; return the wrap states compared.

    MuJoCo wraps beyond half a turn, and hooks no line round an obstacle that is not beside it.
    """
    state = Bands(models).solve(R)
    lengths, moments = mujoco_paths(models, sides).solve(R)
    told = state.wrap <= WrapState.CLEAR
    told &= (state.wrap == WrapState.CLEAR) | np.array([beside(model, R) for model in models])
    # m: two closed forms of the same path
    np.testing.assert_allclose(state.lengths[told], lengths[told], rtol=0, atol=1e-9)
    np.testing.assert_allclose(state.moment_vectors[told], moments[told], rtol=0, atol=1e-9)
    return state.wrap[told]


def test_spheres_on_either_bone_are_mujocos() -> None:
    wrap = np.concatenate(
        [check_against_mujoco(many(Sphere, 300, seed), None, rotations(1, seed)[0])
         for seed in range(3)]
    )  # fmt: skip
    assert [(wrap == each).sum() > 50 for each in (WrapState.WRAPPED, WrapState.CLEAR)] == [1, 1]


def test_cylinders_on_either_bone_are_mujocos_on_the_same_side() -> None:
    wraps = []
    for seed in range(3):
        models, R = many(Cylinder, 300, seed), rotations(1, seed)[0]
        sides = []
        for model in models:
            bone = R if model.bone == 'humerus' else STILL
            line = bone.T @ (R @ model.insertion - model.origin)
            aside = np.cross(line, model.axis)
            sides.append(model.centre + aside / np.linalg.norm(aside))
        wraps.append(check_against_mujoco(models, np.array(sides), R))
    wrap = np.concatenate(wraps)
    assert [(wrap == each).sum() > 100 for each in (WrapState.WRAPPED, WrapState.CLEAR)] == [1, 1]


# What is refused


@pytest.mark.parametrize(
    ('kind', 'changed', 'said'),
    [
        (Straight, {'origin': (0.0, 0.0)}, r'origin: \(0.0, 0.0\) given, 3 finite numbers in m'),
        (Straight, {'insertion': (0.0, 0.0, np.inf)}, r'insertion: .* given, 3 finite numbers'),
        (ViaPoints, {'on_humerus': ((0.0, np.nan, 0.0),)}, r'on_humerus\[0\]: .* given'),
        (Sphere, {'radius': 0.0}, r'radius: 0.0 given, a finite length > 0 in m expected'),
        (Sphere, {'bone': 'ulna'}, "bone: 'ulna' given, 'scapula' or 'humerus' expected"),
        (Cylinder, {'axis': (0.0, 0.0, 0.0)}, r'axis: .* given, 3 finite numbers, not all 0'),
        (DoubleCylinder, {'second_radius': np.nan}, 'second_radius: nan given'),
        (CappedCylinder, {'turn': 'over'}, "turn: 'over' given, one of right-handed, left-handed"),
    ],
)
def test_a_model_that_is_none_is_refused(kind: Model, changed: dict, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        replace(one(kind, np.random.default_rng(0)), **changed)


def test_bands_are_of_one_kind_and_poses_are_rotations() -> None:
    straight = many(Straight, 2)
    with pytest.raises(ValueError, match='models: 0 given, 1 or more of one kind expected'):
        Bands([])
    with pytest.raises(ValueError, match='models: 3 given, 1 or more of one kind expected'):
        Bands([*straight, *many(Sphere, 1)])
    with pytest.raises(ValueError, match=r'rotation: shape \(3,\) given, \(3, 3\) expected'):
        straight[0].solve((1, 2, 3))
    with pytest.raises(ValueError, match=r'rotation: R\^T R is not the identity'):
        straight[0].solve(2.0 * STILL)
    with pytest.raises(ValueError, match=r'rotations\[1\]: its determinant is -1'):
        Bands(straight).solve_batch([STILL, -STILL])
    with pytest.raises(ValueError, match='points: 1 given, at least 2 needed'):
        straight[0].solve(STILL).path(1)
    assert len(Bands(straight).solve_batch([])) == 0
