# SPDX-License-Identifier: Apache-2.0
"""The command `linkedplane`, in this process: what it prints, its one line where it fails."""

from __future__ import annotations

import sys
from typing import Any

import pytest

from linkedplane_ros.commands.main import main

PROGRAM = [sys.executable, '-m', 'linkedplane_ros.commands']


def exit_status(*arguments: Any) -> int:
    """Return the exit status of a command."""
    return main([str(argument) for argument in arguments])


def command_output(capsys: pytest.CaptureFixture[str], *arguments: Any) -> str:
    """Return what a command that must do its work prints."""
    assert exit_status(*arguments) == 0
    out, err = capsys.readouterr()
    assert err == ''
    return out


def command_fault(capsys: pytest.CaptureFixture[str], *arguments: Any) -> str:
    """Return the one line of a command whose input is at fault."""
    assert exit_status(*arguments) == 1
    out, err = capsys.readouterr()
    assert out == ''
    assert err.startswith('linkedplane: ')
    assert err.endswith('\n')
    assert err.count('\n') == 1
    return err
