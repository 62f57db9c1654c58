# SPDX-License-Identifier: Apache-2.0
"""The state of a fit on disk: a fit that was stopped continues to the same result."""

from __future__ import annotations

import hashlib
import json
import math
import time
from pathlib import Path
from typing import Any

from ...errors import LinkedPlaneError
from ...files import replace_when_complete, require_regular

FORMAT = 'linkedplane_ros/fit_checkpoint'
EVERY = 5.0  # s


class Checkpoint:
    """A file with the state of a search, replaced every few seconds.

    Parameters
    ----------
    path
        The file.
    fingerprint
        Of the fit (`fitting.fit_fingerprint`): the state of another fit is refused.

    """

    def __init__(self, path: Path, fingerprint: str) -> None:
        """Name the file and the fit."""
        self.path, self.fingerprint = path, fingerprint
        self._written = -math.inf

    @property
    def written(self) -> bool:
        """Whether this fit's state is on disk."""
        return self._written > -math.inf

    def write_if_due(self, search: Any) -> None:
        """Write the state of a search if the last one written is EVERY seconds old."""
        if time.monotonic() - self._written >= EVERY:
            self.write(search.state())

    def write(self, state: dict[str, Any]) -> None:
        """Write a state, in types that JSON has; LinkedPlaneError where it cannot be written."""
        content = {'format': FORMAT, 'fit': self.fingerprint, 'digest': digest(state)}
        text = json.dumps(content | {'state': state})
        with replace_when_complete(self.path, LinkedPlaneError) as part:
            part.write_text(text, encoding='utf-8')
        self._written = time.monotonic()

    def read(self) -> dict[str, Any]:
        """Return the state on disk; LinkedPlaneError if it cannot be read, or is of another fit."""
        try:
            require_regular(self.path, LinkedPlaneError)
            content = json.loads(self.path.read_text(encoding='utf-8'))
            if content['format'] != FORMAT:
                raise KeyError
            fit, state = content['fit'], dict(content['state'])
            if content['digest'] != digest(state):
                raise LinkedPlaneError(
                    f'{self.path}: damaged; --force instead of --resume starts again'
                )
        except OSError as error:
            raise LinkedPlaneError(f'{self.path}: cannot be read: {error.strerror}') from None
        except (KeyError, RecursionError, TypeError, UnicodeDecodeError, json.JSONDecodeError):
            raise LinkedPlaneError(f'{self.path}: not a checkpoint of a fit, or cut') from None
        if fit != self.fingerprint:
            raise LinkedPlaneError(
                f'{self.path}: of another fit: the model, the data or an option differs'
            )
        self._written = time.monotonic()
        return state

    def remove(self) -> None:
        """Remove the file, if it is there."""
        self.path.unlink(missing_ok=True)


def digest(state: dict[str, Any]) -> str:
    """Return what tells a state from every other one."""
    return hashlib.sha256(json.dumps(state).encode()).hexdigest()
