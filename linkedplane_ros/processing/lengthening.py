# SPDX-License-Identifier: Apache-2.0
"""How fast bands grow longer where only poses are known: from one frame to the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..types import Floats, Stamps


@dataclass
class LengthRates:
    """Differences of lengths in time, each against the frame before; live and in recordings."""

    _stamp: int | None = None
    _lengths: Floats | None = None

    def take(self, stamps: Stamps, lengths: Floats) -> Floats:
        """Return the rates of the next frames.

        Parameters
        ----------
        stamps
            (m,) ns.
        lengths
            (m, n) m.

        Returns
        -------
        Floats
            (m, n) m/s; NaN of the first frame of all, and where time does not go on.
        """
        rates = np.full(lengths.shape, np.nan)
        if not len(stamps):
            return rates
        if self._stamp is not None and self._lengths is not None:
            stamps = np.concatenate(([self._stamp], stamps))
            lengths = np.vstack((self._lengths, lengths))
        steps = np.diff(stamps)
        goes_on = steps > 0
        found = np.full((len(steps), lengths.shape[1]), np.nan)
        found[goes_on] = np.diff(lengths, axis=0)[goes_on] / (1e-9 * steps[goes_on, np.newaxis])
        rates[len(rates) - len(found) :] = found
        self._stamp, self._lengths = int(stamps[-1]), lengths[-1]
        return rates
