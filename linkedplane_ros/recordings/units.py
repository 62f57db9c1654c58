# SPDX-License-Identifier: Apache-2.0
"""The unit of a recording's angles: who says it, and whether the angles themselves agree.

One unit holds for a whole recording. It is what the recording itself says: by the names of its
columns, or by lines above them. `--degrees` and `--radians` say it where the recording does not,
or says both; where nothing does, the angles are in radians, if their range allows it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..errors import RecordingError
from ..joints.joint_state import FULL_CIRCLE
from ..types import Floats

FLAGS = {True: '--degrees', False: '--radians'}
SETTLE = '--degrees or --radians settles it'
LONGEST = 300  # characters that are searched for a unit: names and lines are shorter

# what stands around a unit in a name: flexion_deg, flexion (deg), flexion/deg; flexion_deg_, as
# MATLAB, and flexion..deg., as R spells the second
DEGREES, RADIANS = 'deg|degs|degree|degrees', 'rad|rads|radian|radians'
_MARK = re.compile(  # the degree sign, also misspelt by a keyboard or by a wrong encoding
    r'(?P<joint>.*?\w)[\W_]*(?:Â)?[°º˚][\W_]*'
)
_UNIT = re.compile(
    rf'(?P<joint>.*?\w)[\W_]+(?:in[\W_]+)?(?:(?P<degrees>{DEGREES})|{RADIANS})[\W_]*', re.I
)
_CAMEL = re.compile(r'(?P<joint>.*[a-z0-9])(?:(?P<degrees>Deg|Degs|Degrees)|Rad|Rads|Radians)')
_WITHIN = re.compile(  # deg_flexion, flexion_deg_filtered
    rf'(?:^|[\W_])(?:(?P<degrees>{DEGREES})|{RADIANS})(?:[\W_]|$)', re.I
)
_OTHER = re.compile(  # units that are neither, and those of speeds
    r'.*?\w[\W_]+(?P<unit>mrad|millirad\w*|grad|grads|gon|gons|turns?|revs?|arcmin|arcsec'
    rf'|(?:{DEGREES}|{RADIANS}|[°º˚])(?:[\W_]*(?:/|per|p)[\W_]*|[\W_]+)s(?:ec|econds?)?[\W_\d]*'
    r'|dps|rpm)[\W_]*',
    re.I,
)


class UnitWord(NamedTuple):
    """What a recording says of its unit."""

    degrees: bool
    source: str
    """Where it says so, as in 'the names of the columns'."""
    certain: bool = True
    """Whether it is the unit of the angles; False: a remark that may be on something else."""


@dataclass(frozen=True)
class AngleUnit:
    """The unit of all angles of a recording."""

    degrees: bool
    source: str
    """Who says so."""
    said: bool = True
    """Whether anybody says so; False: radians are only assumed."""

    @property
    def fact(self) -> str:
        """The unit and who says so, for an output's metadata."""
        return f'{"deg" if self.degrees else "rad"}: {self.source}'

    @property
    def radians(self) -> float:
        """The unit, in rad."""
        return math.pi / 180.0 if self.degrees else 1.0


def decide_unit(
    path: Path,
    degrees: bool | None,
    words: Sequence[UnitWord],
    assumed: str = 'nothing says otherwise',
) -> AngleUnit:
    """Return the unit of a recording.

    Parameters
    ----------
    path
        The recording.
    degrees
        What the user says by --degrees or --radians; None: nothing.
    words
        What the recording says.
    assumed
        Why it is radians where nobody says anything.

    Raises
    ------
    RecordingError
        If the recording says both, or only remarks on degrees, and the user says nothing; or if
        they contradict each other.
    """
    said = {word.degrees: word.source for word in reversed(words) if word.certain}
    remarks = {word.degrees: word.source for word in reversed(words) if not word.certain}
    spoken = {**remarks, **said}
    if degrees is not None:
        if said and list(spoken) == [not degrees]:
            raise RecordingError(
                f'{path}: {FLAGS[degrees]}, but {"rad" if degrees else "deg"} by '
                f'{said[not degrees]}; leave {FLAGS[degrees]} out, or correct the file'
            )
        return AngleUnit(degrees, FLAGS[degrees])
    if said and len(spoken) == 2:
        raise RecordingError(
            f'{path}: degrees by {spoken[True]}, but radians by {spoken[False]}; {SETTLE}'
        )
    if said:
        [(unit, source)] = said.items()
        return AngleUnit(unit, source)
    if True in remarks:
        raise RecordingError(f'{path}: {remarks[True]}: are the angles in degrees? {SETTLE}')
    return AngleUnit(False, assumed, said=False)


def split_unit(name: str) -> tuple[str, bool | None]:
    """Return a column's name without its unit, and whether that is degrees; None: it has none.

    A unit that is not the end of the name stays in it.
    """
    if len(name) > LONGEST:
        return name, None
    if match := _MARK.fullmatch(name):
        return match['joint'], True
    if match := _UNIT.fullmatch(name) or _CAMEL.fullmatch(name):
        return match['joint'], match['degrees'] is not None
    if match := _WITHIN.search(name):
        return name, match['degrees'] is not None
    return name, None


def name_words(
    path: Path, names: Sequence[str], alone: bool, kind: str = 'column'
) -> tuple[UnitWord, ...]:
    """Return what the names of the columns or joints say.

    Parameters
    ----------
    path
        The recording.
    names
        Of its columns of angles, or joints that turn.
    alone
        Whether nobody else says a unit: then all names or none have one.
    kind
        'column' or 'joint': whose names they are.

    Raises
    ------
    RecordingError
        If the names have several units, or some have none, or one that is neither deg nor rad.
    """
    for name in names:
        if len(name) <= LONGEST and (match := _OTHER.fullmatch(name)):
            raise RecordingError(
                f'{path}: {kind} {name!r}: angles in deg or rad expected, not in {match["unit"]}'
            )
    units = {split_unit(name)[1]: name for name in reversed(names)}
    texts = {True: 'in degrees', False: 'in radians', None: 'without a unit'}
    named = [(unit, units[unit]) for unit in (True, False) if unit in units]
    if len(named) == 2 or (named and alone and None in units):
        (one, name), (other, second), *_ = units.items()
        raise RecordingError(
            f'{path}: {kind} {name!r} is {texts[one]}, {second!r} {texts[other]}; '
            f'one unit for all {len(names)} expected'
        )
    return tuple(UnitWord(unit, f'the names of the {kind}s') for unit, _ in named)


class AngleRange:
    """The smallest and the largest angle that was met of each joint, in the recording's unit.

    Parameters
    ----------
    names
        (n) the joints.
    units
        (n) what is written behind a joint's range; None: nothing.
    """

    def __init__(self, names: Sequence[str], units: Sequence[str] | None = None) -> None:
        """Begin with no angle."""
        self.names = tuple(names)
        self.units = tuple(units or ('',) * len(self.names))
        self.lowest = [math.inf] * len(self.names)
        self.highest = [-math.inf] * len(self.names)

    def extend(self, angles: Floats) -> None:
        """Take angles (k, n) in; what is not finite is passed over."""
        finite = np.isfinite(angles)
        lowest = angles.min(axis=0, where=finite, initial=math.inf).tolist()
        highest = angles.max(axis=0, where=finite, initial=-math.inf).tolist()
        self.lowest = list(map(min, self.lowest, lowest))
        self.highest = list(map(max, self.highest, highest))

    def extend_named(self, names: Sequence[str], angles: Floats) -> None:
        """Take a message's angles (m,) in, those of the joints among its names (m)."""
        if len(names) != len(angles):
            return
        named = dict(zip(names, angles.tolist(), strict=True))
        for k, name in enumerate(self.names):
            angle = named.get(name, math.nan)
            if math.isfinite(angle):
                self.lowest[k] = min(self.lowest[k], angle)
                self.highest[k] = max(self.highest[k], angle)

    @property
    def largest(self) -> float:
        """The largest amount of an angle; 0 where there is none."""
        ends = (abs(end) for end in (*self.lowest, *self.highest) if math.isfinite(end))
        return max(ends, default=0.0)

    def describe(self) -> str:
        """Return each joint's range in words."""
        ranges = zip(self.names, self.lowest, self.highest, self.units, strict=True)
        met = (f'{name} {a:.4g} to {b:.4g}{unit}' for name, a, b, unit in ranges if a <= b)
        return ', '.join(met) or 'no angles'

    def check_circle(self, path: Path) -> None:
        """Raise a RecordingError if an angle, were it in radians, is beyond a full circle."""
        if self.largest > FULL_CIRCLE:
            raise doubt_radians(path, self, 'no angle in radians is beyond 2 pi')


def doubt_radians(path: Path, met: AngleRange, why: str) -> RecordingError:
    """Return the fault of a recording whose angles are taken for radians, and are none."""
    return RecordingError(
        f'{path}: degrees? Nothing says the unit of its angles ({met.describe()}), and {why}; '
        f'{SETTLE}'
    )
