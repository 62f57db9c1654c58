# SPDX-License-Identifier: Apache-2.0
"""A muscle model in words: what `linkedplane info` prints."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import resources

import numpy as np

from ..errors import escape_controls
from ..muscle.broad_muscle import BroadMuscle
from ..muscle.parts import COORDINATES
from .linked_plane_solver import LinkedPlaneSolver
from .range_check import check_model
from .states import WrapState


def model_report(muscle: BroadMuscle) -> Iterator[str]:
    """Yield the lines: the model, its bands with the arm at the side, warnings."""
    heads = count_text(len(muscle.heads), 'head')
    yield f'{muscle.name}: {count_text(len(muscle.band_names), "band")}, {heads}'
    yield escape_controls(muscle.source)
    yield f'licence: {escape_controls(muscle.licence) or "not stated"}'
    yield 'right shoulder; x lateral, y anterior, z superior; lengths in mm, angles in rad'
    yield from sphere_lines(muscle)
    yield ''
    yield from band_lines(muscle)
    yield ''
    for head in muscle.heads:
        yield f'{head.name}: {", ".join(head.bands)}; represented by {head.represented_by}'
    for mark in muscle.landmarks:
        at = ' '.join(f'{1e3 * x:.1f}' for x in mark.at)
        yield f'landmark {mark.name}: {mark.bone} {at}'
    yield from warning_lines(muscle)


def sphere_lines(muscle: BroadMuscle) -> Iterator[str]:
    """Yield what the obstacle spheres move with, and how many there are."""
    places = {
        'moving': "in their bands' moving frames",
        'ground': f'on the {muscle.bones.ground}',
        **{bone: f'on the {bone}' for bone in muscle.bones.names[1:]},
    }
    shared = muscle.bands_by_sphere()
    for frame, place in places.items():
        bands = [each for first, each in shared.items() if muscle.sphere_frames[first] == frame]
        if bands:
            yield (
                f'{count_text(len(bands), "obstacle sphere")} {place}, '
                f'for {count_text(sum(map(len, bands)), "band")}'
            )


def band_lines(muscle: BroadMuscle) -> Iterator[str]:
    """Yield a table: each band's ends, sphere and length with the arm at the side."""
    state = LinkedPlaneSolver(muscle).solve(np.eye(3))
    n = len(muscle.band_names)
    bones = [muscle.bones.of_bands(ends, n) for ends in ('origin', 'insertion')]
    on = [f' ({each[0]})' if len(set(each)) == 1 else '' for each in bones]
    yield (f'{"band":<14}{"head":<12}{f"origin{on[0]}":>24}{f"insertion{on[1]}":>24}'
           f'{"radius":>8}{"phi":>8}{"length":>8}  wrap')  # fmt: skip
    for i, band in enumerate(muscle.band_names):
        origin, insertion = (
            ' '.join(f'{1e3 * x:7.1f}' for x in point[i])
            for point in (muscle.origins, muscle.insertions)
        )
        phi = 'theta' if i == 0 else f'{muscle.plane_angles[i]:.3f}'
        yield (f'{band:<14}{muscle.find_head(band):<12}{origin:>24}{insertion:>24}'
               f'{1e3 * muscle.sphere_radii[i]:8.1f}{phi:>8}{1e3 * state.lengths[i]:8.1f}'
               f'  {WrapState(state.wrap[i]).name.lower()}')  # fmt: skip
    yield from bone_lines(muscle)
    yield ''
    yield f'arm at the side: theta {state.theta:.6f} rad, total {1e3 * state.total_length:.3f} mm'


def bone_lines(muscle: BroadMuscle) -> Iterator[str]:
    """Yield which bands arise and end on which bone, where there is a choice."""
    for ends, verb in ('origin', 'arise from'), ('insertion', 'end on'):
        bones = muscle.bones.of_bands(ends, len(muscle.band_names))
        for bone in muscle.bones.names if len(set(bones)) > 1 else ():
            pairs = zip(muscle.band_names, bones, strict=True)
            bands = [band for band, each in pairs if each == bone]
            if bands:
                yield f'{verb} the {bone}: {", ".join(bands)}'


def warning_lines(muscle: BroadMuscle) -> Iterator[str]:
    """Yield the range of motion that was checked, and what is wrong there."""
    check = check_model(muscle)
    spans = ', '.join(
        f'{name} {low:.0f} to {high:.0f}'
        for name, (low, high) in zip(COORDINATES, np.degrees(check.range_of_motion), strict=True)
    )
    whose = 'its' if muscle.range_of_motion else "the deltoid's (it states none)"
    yield (
        f'range of motion, {whose}: {spans} deg; {count_text(check.poses, "pose")} checked, '
        f'{count_text(len(check.warnings), "warning")}'
    )
    for line in check.warnings:
        yield f'warning: {line}'


def count_text(count: int, what: str) -> str:
    """Return a number of things in words: no band, 1 band, 2 bands."""
    return f'{count or "no"} {what}{"s" * (count != 1)}'


def schema_line() -> str:
    """Return the line of a model file that tells an editor its format."""
    schema = resources.files('linkedplane_ros') / 'models' / 'broad_muscle.schema.json'
    return f'# yaml-language-server: $schema={schema}'
