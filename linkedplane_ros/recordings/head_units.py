# SPDX-License-Identifier: Apache-2.0
"""The unit of a table's angles, as the lines above the names of its columns say it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from unicodedata import normalize

from ..errors import RecordingError
from .units import DEGREES, LONGEST, RADIANS, UnitWord

LEFTOVERS = ' \t\r\n\v\f,;"\''  # of a spreadsheet, around what a line says
_KEY = re.compile(r'(?P<key>[^\s=,;]+)(?P<between>[\s=,;]*)(?P<rest>.*)')
_SENTENCE = re.compile(
    rf'.*\bangles?\b.*\bin (?:(?P<degrees>{DEGREES})|{RADIANS})\b.*'
    rf'|(?:angles?|(?:angular |angle )?units?)[\s=:]+(?:(?P<unit>{DEGREES})|{RADIANS})',
    re.I,
)

# degrees and radians in prose; no letter stands beside them, so that neither an upgrade nor a
# Freiheitsgrad is one
_BEFORE, _AFTER = r'(?<![^\W\d_])', r'(?![^\W\d_])'
_OTHER_DEGREES = (  # of freedom, of temperature, of a polynomial
    r'(?![\W_]+(?:of[\W_]+freedom|d[eai][\W_]+liber[td]|polynom|spline|celsius|fahrenheit))'
    rf'(?! ?[cfk]{_AFTER})'
)
_SPEAKS_OF_DEGREES = re.compile(
    rf'(?:(?:{_BEFORE}(?:{DEGREES}|degr(?:é|Ã©)s?|grad|grade[nr]|grad[oi]|grados|graus?|градус\w*)'
    rf'|indegrees?|(?-i:[a-z]Deg)(?:s|rees?)?){_AFTER}|[°˚]|(?<!\w)º|º(?=[\W_]*$)){_OTHER_DEGREES}',
    re.I,
)
_SPEAKS_OF_RADIANS = re.compile(
    rf'(?:{_BEFORE}(?:{RADIANS}|radian\w*|bogenma(?:ß|ss))|inradians?|(?-i:[a-z]Rad)(?:s|ians?)?)'
    rf'{_AFTER}(?!\s*(?:/|per{_AFTER}))',  # a speed is none
    re.I,
)
_OWN = 'made_by: linkedplane_ros'  # in the head of an output: it is in rad, whatever it was made of


def head_words(path: Path, head: Sequence[str]) -> tuple[UnitWord, ...]:
    """Return what the lines above the names of the columns say.

    The rules are those of OpenSim's Storage.cpp, also for the comments of a CSV: `inDegrees` is
    `yes` or `y` in any case; a .mot without `version` is a motion of SIMM, in degrees; and its
    sentence `Angles are in degrees.` counts. Beyond these, a spreadsheet's leftovers are no part
    of a value; what Storage.cpp takes for no (`inDegrees=true`) is refused; and what it passes
    over, another line on degrees or on radians, is a remark.

    Parameters
    ----------
    path
        The table.
    head
        All its lines before the names, in their order.

    Raises
    ------
    RecordingError
        If inDegrees is neither yes nor no.
    """
    flags: list[UnitWord] = []
    sentences: list[UnitWord] = []
    remarks: list[UnitWord] = []
    version = 0
    opensim = path.suffix.lower() in ('.mot', '.sto')
    for line, text in enumerate(head, 1):
        bare = text.strip(LEFTOVERS)
        prose = bare.lstrip('#' + LEFTOVERS)
        match = _KEY.fullmatch(bare if opensim else prose)
        key, between, rest = match.groups() if match else ('', '', '')
        rest = rest.strip(LEFTOVERS).lower()
        if key.lower() == 'indegrees' and rest in ('yes', 'y', 'no', 'n'):
            flags.append(UnitWord(rest[0] == 'y', 'inDegrees in the file'))
            continue
        if key.lower() == 'indegrees' and '=' in between:
            raise RecordingError(f'{path}:{line}: inDegrees is {rest[:60]!r}; yes or no expected')
        if key == 'version':
            number = re.match(r'[+-]?\d+', rest)  # as atoi does
            version = int(number[0]) if number else 0
        degrees = spoken_unit(bare)
        if degrees is None:
            continue
        if len(bare) <= LONGEST and _SENTENCE.fullmatch(prose):
            sentences.append(UnitWord(degrees, f'{bare[:60]!r} in the file'))
        else:
            remarks.append(UnitWord(degrees, f'{bare[:60]!r} in line {line}', certain=False))
    if opensim and version < 1 and '.mot' in path.name.lower():  # as Storage.cpp looks for it
        flags.append(UnitWord(True, 'its head without version=, as in SIMM'))
    elif opensim and version < 1 and not flags and not sentences:
        why = "a .sto without version= and inDegrees, in degrees as SIMM's or in radians"
        remarks.append(UnitWord(True, why, certain=False))
    if any(text.lstrip('# ').startswith(_OWN) for text in head):
        remarks = []
    return (*flags, *sentences, *remarks)


def spoken_unit(text: str) -> bool | None:
    """Return whether a text speaks of degrees; None where it speaks of radians too, or neither."""
    text = normalize('NFC', text)
    degrees = _SPEAKS_OF_DEGREES.search(text) is not None
    radians = _SPEAKS_OF_RADIANS.search(text) is not None
    return degrees if degrees != radians else None
