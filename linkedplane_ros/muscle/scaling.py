# SPDX-License-Identifier: Apache-2.0
"""A model at a subject's size: by factors, or by what was measured on the subject.

Points on a bone scale along its axes, from the centre of the joint. A sphere stays a sphere: its
radius scales by the geometric mean of the three factors of its bone; in a moving frame, which
belongs to no bone, radius and centre scale by that of all six. Plane angles stay as they are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ModelError, describe_value
from ..types import Floats, Point
from .bones import BALL_JOINT
from .definition import Definition, expand_frame
from .parts import (
    METRES,
    Curve,
    Curves,
    Landmark,
    Listed,
    multiply_point,
)
from .validity import JOINT_CENTRE, LIMIT
from .yaml_mapping import YamlMapping, is_version, read_yaml

FORMAT = 'linkedplane_ros/subject'
VERSION = 1
BONES = BALL_JOINT.names
LEAST, MOST = 0.2, 5.0  # factors: a newborn's arm is a fifth of an adult's
LEAST_MEASURED, MOST_MEASURED = 0.5, 2.0  # a person's against the model's; beyond, a unit is wrong
FLAT = 0.1  # of the farthest landmark's distance: below, an axis has no factor of its own

Pair = tuple[str, tuple[float, ...], tuple[float, ...]]
"""A bone, what the model has there, and what was measured: a point's 3 numbers or a distance."""


@dataclass(frozen=True)
class Scale:
    """Factors along x, y and z of each bone.

    Raises
    ------
    ModelError
        Unless all factors are from 0.2 to 5.

    """

    scapula: Point = (1.0, 1.0, 1.0)
    humerus: Point = (1.0, 1.0, 1.0)
    basis: str = ''
    """Where the factors come from, if they were measured."""

    def __post_init__(self) -> None:
        """Check the factors."""
        for bone in BONES:
            given = getattr(self, bone)
            factors = read_factors(given)
            if len(factors) != 3:
                reason = f'{describe_value(given)} given, 3 factors expected'
                raise ModelError(f'scale: {bone}: {reason}')
            object.__setattr__(self, bone, tuple(factors))
        wrong = [each for each in (*self.scapula, *self.humerus) if not LEAST <= each <= MOST]
        if wrong:
            raise ModelError(
                f'scale: {wrong[0]:g} given, a factor > 0 expected, from {LEAST:g} to {MOST:g}'
            )

    @property
    def uniform(self) -> bool:
        """Whether all factors are the same."""
        return len({*self.scapula, *self.humerus}) == 1

    def __str__(self) -> str:
        if self.uniform:
            text = f'by {self.scapula[0]:.6g}'
        else:
            bones = zip(BONES, (self.scapula, self.humerus), strict=True)
            text = 'by ' + ', '.join(
                f'{bone} {" ".join(f"{factor:.6g}" for factor in factors)}'
                for bone, factors in bones
            ) + ' (x y z)'  # fmt: skip
        return f'{text}, {self.basis}' if self.basis else text


def parse_scale(given: float | str | Path | Sequence[float] | Scale, model: Definition) -> Scale:
    """Return the scale that is given for a model, in one of the forms of `BroadMuscle.scaled`."""
    if isinstance(given, Scale):
        return given
    if isinstance(given, (str, Path)):
        if Path(given).suffix in ('.yaml', '.yml'):
            return measure_scale(read_yaml(Path(given)), model)
        try:
            factors = [float(part) for part in str(given).split(',')]
        except ValueError:
            factors = []
    else:
        factors = read_factors(given)
    if len(factors) not in (1, 3, 6):
        raise ModelError(
            f'scale: {describe_value(given)} given; one factor, 3 (x,y,z), 6 '
            "(the scapula's, then the humerus's) or a subject's .yaml file expected"
        )
    x, y, z, *others = factors * 3 if len(factors) == 1 else factors
    a, b, c = others or (x, y, z)
    return Scale((x, y, z), (a, b, c))


def read_factors(given: Any) -> list[float]:
    """Return a number, or a sequence of numbers, as a list; an empty one for anything else."""
    try:
        factors = np.atleast_1d(np.asarray(given))
    except ValueError:  # rows of different lengths
        return []
    is_list = factors.dtype.kind in 'iuf' and factors.ndim == 1
    return factors.astype(np.float64).tolist() if is_list else []


def scale_definition(model: Definition, scale: Scale) -> Definition:
    """Return a definition at another size, in its own units; its source says the scale."""
    if scale.uniform and scale.scapula[0] == 1.0:
        return model
    if model.bones != BALL_JOINT and scale.scapula != scale.humerus:
        raise ModelError(
            f'scale: {model.name} has its points on {", ".join(model.bones.names)}; one factor, or '
            '3 (x,y,z), for all of them expected'
        )
    bones = dict.fromkeys(model.bones.names, scale.scapula)
    bones[model.bones.joint] = scale.humerus
    middle = geometric_mean(*scale.scapula, *scale.humerus)
    frames = {**bones, 'ground': scale.scapula, 'moving': (middle,) * 3}
    factors = [frames[frame] for frame in expand_frame(model.sphere_frame, len(model.band_names))]
    s = model.s_of_bands
    x, y, z = (
        scale_curve(curve, [each[axis] for each in factors], s)
        for axis, curve in enumerate(model.sphere_centre)
    )
    size = geometric_mean(*scale.scapula)
    n1, n2, n3 = (
        n * (size / f) for n, f in zip(model.reference_normal, scale.scapula, strict=True)
    )
    return replace(
        model,
        source=f'{model.source}; scaled {scale}',
        origin=scale_attachments(model.origin, scale.scapula),
        insertion=scale_attachments(model.insertion, scale.humerus),
        sphere_centre=(x, y, z),
        sphere_radius=scale_curve(
            model.sphere_radius, [geometric_mean(*each) for each in factors], s
        ),
        ground_point=model.ground_point and multiply_point(model.ground_point, scale.scapula),
        humeral_point=model.humeral_point and multiply_point(model.humeral_point, scale.humerus),
        reference_normal=(n1, n2, n3),
        interference_spheres=tuple(
            replace(
                each,
                centre=multiply_point(each.centre, scale.scapula),
                radius=each.radius * size,
            )
            for each in model.interference_spheres
        ),
        landmarks=tuple(
            replace(each, at=multiply_point(each.at, bones[each.bone])) for each in model.landmarks
        ),
    )


def geometric_mean(*factors: float) -> float:
    """Return the geometric mean; of equal factors, each of them to the bit."""
    if len(set(factors)) == 1:
        return factors[0]
    return float(np.exp(np.log(factors).mean()))


def scale_attachments(curves: Curves, factors: Point) -> Curves:
    """Return attachments on a bone with each coordinate times its factor."""
    x, y, z = (curve.multiply(factor) for curve, factor in zip(curves, factors, strict=True))
    return x, y, z


def scale_curve(curve: Curve, factors: list[float], s: Floats) -> Curve:
    """Return a quantity times a factor for each band; it becomes a list if they differ."""
    if len(set(factors)) == 1:
        return curve.multiply(factors[0])
    return Listed(tuple((curve.evaluate(s) * factors).tolist()))


def measure_scale(file: YamlMapping, model: Definition) -> Scale:
    """Return the factors that a subject's file gives, by least squares over the landmarks.

    Points give a factor for each axis of their bone, distances one for the bone. A bone that was
    not measured takes the other's factors. ModelError names file and key.
    """
    file.check_keys(('format', 'version', 'units'), ('points', 'distances'))
    for key, wanted, suits in (
        ('format', FORMAT, file.content['format'] == FORMAT),
        ('version', VERSION, is_version(file.content['version'], VERSION)),
    ):
        if not suits:
            given = describe_value(file.content[key])
            raise file.fault(key, f'{given} given, {wanted!r} expected')
    units = file.mapping('units')
    units.check_keys(('length',))
    metres = METRES[units.choice('length', METRES)] / METRES[model.length]
    if ('points' in file) == ('distances' in file):
        raise file.fault('points', 'or distances expected, one of the two')
    if model.bones != BALL_JOINT:
        raise ModelError(
            f'{file.file}: measurements are for models of scapula and humerus; {model.name} has '
            f'its points on {", ".join(model.bones.names)}'
        )
    kind = 'points' if 'points' in file else 'distances'
    far = LIMIT / METRES[units.content['length']]
    pairs = list({'points': point_pairs, 'distances': distance_pairs}[kind](file, model))
    wrong = [each for *_, measured in pairs for each in measured if not abs(each) < far]
    if wrong:
        raise file.fault(kind, f'{wrong[0]:g} given, less than {LIMIT:g} m expected; another unit?')
    factors: dict[str, Point] = {}
    off: list[float] = []
    for bone in BONES:
        own = [(mine, theirs) for place, mine, theirs in pairs if place == bone]
        if own:
            mine, theirs = np.array([a for a, _ in own]), metres * np.array([b for _, b in own])
            factors[bone] = fit_factors(mine, theirs, f'{file.file}: {bone}')
            off += np.square(theirs - mine * factors[bone][: mine.shape[1]]).ravel().tolist()
    rms = 1e3 * METRES[model.length] * math.sqrt(sum(off) / len(pairs))
    scapula = factors.get('scapula') or factors['humerus']
    humerus = factors.get('humerus') or factors['scapula']
    basis = f'as {file.file} has it ({len(pairs)} {kind}, off by {rms:.1f} mm rms)'
    return Scale(scapula, humerus, basis)


def landmarks_by_name(file: YamlMapping, model: Definition) -> dict[str, Landmark]:
    """Return the model's landmarks by their names."""
    if not model.landmarks:
        raise ModelError(f'{file.file}: the model {model.name} has no landmarks to measure by')
    return {each.name: each for each in model.landmarks}


def point_pairs(file: YamlMapping, model: Definition) -> Iterator[Pair]:
    """Yield the bone, the model's and the subject's place of each measured landmark."""
    known, given = landmarks_by_name(file, model), file.mapping('points')
    given.check_keys((), known)
    for name in given.content:
        yield known[name].bone, known[name].at, given.point(name)
    if not given.content:
        raise file.fault('points', 'none given; ' + ', '.join(known) + ' are known')


def distance_pairs(file: YamlMapping, model: Definition) -> Iterator[Pair]:
    """Yield the bone, the model's and the subject's distance of each measured pair."""
    known = landmarks_by_name(file, model)
    listed = file.content['distances']
    if not isinstance(listed, list) or not listed:
        raise file.fault('distances', 'a list of {from: ..., to: ..., length: ...} expected')
    for i, content in enumerate(listed):
        each = YamlMapping(file.file, f'distances[{i}]', content)
        each.check_keys(('from', 'to', 'length'))
        ends = [each.choice(key, (*known, JOINT_CENTRE)) for key in ('from', 'to')]
        bones = {known[end].bone for end in ends if end != JOINT_CENTRE}
        if len(bones) != 1 or ends[0] == ends[1]:
            expected = f'another landmark on the bone of {ends[0]} expected'
            raise each.fault('to', f'{describe_value(ends[1])} given; {expected}')
        one, other = ((0.0, 0.0, 0.0) if end == JOINT_CENTRE else known[end].at for end in ends)
        yield bones.pop(), (math.dist(one, other),), (each.number('length'),)


def fit_factors(mine: Floats, theirs: Floats, where: str) -> Point:
    """Return the factors of least squares that take `mine` (k, 3) or (k, 1) to `theirs`.

    An axis along which the landmarks hardly extend takes the mean of the others.
    """
    extent = np.abs(mine).max(axis=0)
    wide = extent > max(FLAT * extent.max(), 1e-12)
    if not wide.any():
        raise ModelError(f'{where}: landmarks that lie in one place give no size')
    factors = (mine * theirs).sum(axis=0)[wide] / np.square(mine).sum(axis=0)[wide]
    wrong = [each for each in factors.tolist() if not LEAST_MEASURED <= each <= MOST_MEASURED]
    if wrong:
        raise ModelError(
            f"{where}: {wrong[0]:.3g} times the model's size by these measurements, "
            f'{LEAST_MEASURED:g} to {MOST_MEASURED:g} expected; the unit, the axes?'
        )
    of_axes = np.full(3, geometric_mean(*factors.tolist()))
    if mine.shape[1] == 3:
        of_axes[wide] = factors
    x, y, z = of_axes.tolist()
    return x, y, z
