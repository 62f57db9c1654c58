# SPDX-License-Identifier: Apache-2.0
"""What is raised for a user's mistake: each kind of fault has its class, all have one base."""

from __future__ import annotations


class LinkedPlaneError(ValueError):
    """Whatever this package refuses; the message names what, where and what is expected."""


class ModelError(LinkedPlaneError):
    """A model that cannot be used; the message names the file or field, the key, the reason."""


class RecordingError(LinkedPlaneError):
    """A recording that cannot be read; the message names the file and the reason."""


class FieldError(ModelError):
    """A field that a model cannot have; the reader of a file names its key instead."""

    def __init__(self, field: str, reason: str, owner: str = '') -> None:
        """Keep the parts of the message: `owner` is the part of a model that has the field."""
        super().__init__(field, reason, owner)
        self.field, self.reason, self.owner = field, reason, owner

    def __str__(self) -> str:
        return f'{self.owner}: {self.field}: {self.reason}'.removeprefix(': ')
