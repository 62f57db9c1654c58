# SPDX-License-Identifier: Apache-2.0
"""Tests on a machine that may be busy: nothing in them is about time."""

from __future__ import annotations

from hypothesis import HealthCheck, settings

unhurried = settings(deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])

PATIENCE = 300.0  # s: the longest wait for anything; only a test that fails waits as long
