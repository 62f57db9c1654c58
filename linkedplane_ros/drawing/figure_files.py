# SPDX-License-Identifier: Apache-2.0
"""Figures by matplotlib, in the house's style, and their files.

matplotlib is loaded when a figure is made; no window is opened and no global setting changed.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import RecordingError
from ..files import replace_when_complete
from ..libraries import advise_install

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLE: dict[Any, Any] = {
    'font.size': 7.0,
    'text.parse_math': False,  # a $ in a name is a $
    'axes.linewidth': 0.6,
    'axes.spines.top': False,
    'axes.spines.right': False,
    'axes.xmargin': 0.02,
    'axes.formatter.useoffset': False,
    'legend.frameon': False,
    'legend.borderpad': 0.0,
    'legend.labelspacing': 0.25,
    'svg.fonttype': 'none',  # text stays text
    'svg.hashsalt': 'linkedplane_ros',  # the same figure is the same file
}


def import_matplotlib() -> Any:
    """Return matplotlib; RecordingError if it is not there.

    Where it can keep its settings and fonts in a temporary folder only, it logs lines of its own:
    they are no concern of who asks for a picture.
    """
    logger = logging.getLogger('matplotlib')
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        import matplotlib
        import matplotlib.font_manager  # both look for their folder, and neither does so again
    except ImportError:
        raise RecordingError(
            f'a picture needs the matplotlib library: {advise_install("matplotlib")}'
        ) from None
    except OSError as error:
        raise RecordingError(
            f'a picture needs a folder that can be written ({error.strerror or error}): set '
            'MPLCONFIGDIR to one, or TMPDIR'
        ) from None
    finally:
        logger.setLevel(level)
    return matplotlib


@contextmanager
def house_style() -> Iterator[None]:
    """Give the block's figures the house's style; RecordingError without matplotlib."""
    with import_matplotlib().rc_context(STYLE):
        yield


def write_figure(figure: Figure, file: Path, kind: str) -> None:
    """Write a figure at 150 dpi; the file appears when it is complete.

    Parameters
    ----------
    figure
        By matplotlib.
    file
        Where.
    kind
        'png' or 'svg'.

    Raises
    ------
    RecordingError
        If the file cannot be written.
    """
    undated = {'Date': None} if kind == 'svg' else None
    with replace_when_complete(file, RecordingError) as part:
        figure.savefig(part, format=kind, dpi=150, metadata=undated)
