"""What is raised for a user's mistake: each kind of fault has its class, all have one base."""

from __future__ import annotations


class LinkedPlaneError(ValueError):
    """Whatever this package refuses; the message names what, where and what is expected."""


class ModelError(LinkedPlaneError):
    """A model that cannot be used; the message names the file or field, the key, the reason."""


class RecordingError(LinkedPlaneError):
    """A recording that cannot be read; the message names the file and the reason."""
