"""The state of a fit on disk, so that one that was stopped goes on as if it had not been."""

from __future__ import annotations

import json
import math
import os
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

FORMAT = 'linkedplane_ros/fit_checkpoint'
EVERY = 5.0  # s


class Checkpoint:
    """A file that is written now and then, whole or not at all."""

    def __init__(self, path: Path, fingerprint: str) -> None:
        """Name the file and the fit."""
        self.path, self.fingerprint = path, fingerprint
        self._written = -math.inf

    @property
    def written(self) -> bool:
        """Whether this fit's state is on disk."""
        return self._written > -math.inf

    def offer(self, search: Any) -> None:
        """Write the state of a search if the last one is some seconds old."""
        if time.monotonic() - self._written >= EVERY:
            self.write(search.state())

    def write(self, state: dict[str, Any]) -> None:
        """Write a state; ValueError in one line where it cannot be."""
        text = json.dumps({'format': FORMAT, 'fit': self.fingerprint, 'state': state})
        new = self.path.with_name(self.path.name + '.new')
        try:
            new.write_text(text, encoding='utf-8')
            os.replace(new, self.path)
        except OSError as error:
            with suppress(OSError):  # where there is nothing to remove
                new.unlink()
            raise ValueError(f'{self.path}: cannot be written: {error.strerror}') from None
        self._written = time.monotonic()

    def read(self) -> dict[str, Any]:
        """Return the state on disk; ValueError in one line if it is none of this fit."""
        try:
            content = json.loads(self.path.read_text(encoding='utf-8'))
            if content['format'] != FORMAT:
                raise KeyError
            fit, state = content['fit'], dict(content['state'])
        except OSError as error:
            raise ValueError(f'{self.path}: cannot be read: {error.strerror}') from None
        except (ValueError, KeyError, TypeError):
            raise ValueError(f'{self.path}: no checkpoint of a fit') from None
        if fit != self.fingerprint:
            raise ValueError(
                f'{self.path}: of another fit: the model, the data or an option is not the same'
            )
        self._written = time.monotonic()
        return state

    def remove(self) -> None:
        """Remove the file, if it is there."""
        self.path.unlink(missing_ok=True)
