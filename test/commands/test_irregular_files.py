# SPDX-License-Identifier: Apache-2.0
"""What is no regular file, or has no end, is refused at once, wherever a file is read."""

from __future__ import annotations

import os
import signal
import socket
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from optional import requires

from linkedplane_ros.commands.main import main
from linkedplane_ros.errors import LinkedPlaneError, RecordingError
from linkedplane_ros.files import MOST_BYTES, read_small_text
from linkedplane_ros.node.launching.parameter_file import read_parameter_file
from linkedplane_ros.recordings.bags.metadata import METADATA, read_metadata


@pytest.fixture(autouse=True)
def limit() -> Iterator[None]:
    """End a test that waits for a file to be written, or reads without end."""
    signal.alarm(60)
    yield
    signal.alarm(0)


def endless(path: Path) -> None:
    path.symlink_to('/dev/zero')


def terabyte(path: Path) -> None:
    with path.open('wb') as file:
        file.truncate(2**40)


def bound_socket(path: Path) -> None:
    there = os.getcwd()
    os.chdir(path.parent)  # the path of a socket is short
    try:
        with socket.socket(socket.AF_UNIX) as bound:
            bound.bind(path.name)
    finally:
        os.chdir(there)


KINDS: dict[str, tuple[Callable[[Path], None], str]] = {
    'FIFO': (lambda path: os.mkfifo(path), 'a FIFO given, a regular file expected'),
    'device': (endless, 'a device given, a regular file expected'),
    'socket': (bound_socket, 'a socket given, a regular file expected'),
    'folder': (lambda path: path.mkdir(), 'Is a directory'),
    'link to nowhere': (lambda path: path.symlink_to('absent'), 'No such file or directory'),
    'link to itself': (lambda path: path.symlink_to(path), 'Too many levels of symbolic links'),
    'terabyte': (terabyte, 'larger than 1 MiB; another file?'),
}
POSE = ['--convention', 'flexion_abduction_rotation', '0', '0.5', '0']
COMMANDS: dict[str, tuple[str, list[str]]] = {
    'model': ('x.yaml', ['info', '{}']),
    'solved model': ('x.yml', ['solve', '--muscle', '{}', *POSE]),
    'scale': ('x.yaml', ['solve', '--scale', '{}', *POSE]),
    'fitted model': ('x.yaml', ['fit', '{}', 'data.csv', 'fitted.yaml']),
    'table': ('x.csv', ['process', '{}', 'out.csv']),
    'OpenSim': ('x.mot', ['process', '{}', 'out.csv']),
    'output': ('x.csv', ['plot', '{}']),
}


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize('command', ['model', 'solved model', 'scale', 'fitted model'])
def test_a_model_and_a_scale_are_regular_files_of_a_mebibyte(
    command: str, kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make, told = KINDS[kind]
    name, args = COMMANDS[command]
    make(tmp_path / name)
    assert main([arg.format(tmp_path / name) for arg in args]) == 1
    line = f'linkedplane: {tmp_path / name}: cannot be read: {told}\n'
    assert capsys.readouterr().err == line


@pytest.mark.parametrize('kind', ['FIFO', 'device', 'socket'])
@pytest.mark.parametrize('command', ['table', 'OpenSim', 'output'])
def test_a_table_is_a_regular_file(
    command: str, kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make, told = KINDS[kind]
    name, args = COMMANDS[command]
    make(tmp_path / name)
    assert main([arg.format(tmp_path / name) for arg in args]) == 1
    assert capsys.readouterr().err == f'linkedplane: {tmp_path / name}: cannot be read: {told}\n'


@requires('rosbags')
@pytest.mark.parametrize('kind', ['FIFO', 'device'])
@pytest.mark.parametrize('name', ['x.mcap', 'x.db3'])
def test_a_bag_consists_of_regular_files(
    name: str, kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make, told = KINDS[kind]
    make(tmp_path / name)
    assert main(['process', str(tmp_path / name), str(tmp_path / 'out.csv')]) == 1
    assert capsys.readouterr().err == f'linkedplane: {tmp_path / name}: cannot be read: {told}\n'
    make(tmp_path / METADATA)
    with pytest.raises(RecordingError, match=f'{METADATA}: cannot be read: {told}'):
        read_metadata(tmp_path)


@requires('scipy')
@pytest.mark.parametrize('kind', ['FIFO', 'device'])
def test_measured_data_are_a_regular_file(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make, told = KINDS[kind]
    make(tmp_path / 'x.csv')
    assert main(['fit', 'deltoid', str(tmp_path / 'x.csv'), str(tmp_path / 'out.yaml')]) == 1
    assert told in capsys.readouterr().err


@pytest.mark.parametrize('kind', KINDS)
def test_a_file_of_parameters_is_a_regular_file_of_a_mebibyte(kind: str, tmp_path: Path) -> None:
    make, told = KINDS[kind]
    make(path := tmp_path / 'x.yaml')
    with pytest.raises(LinkedPlaneError, match=f'^params_file: {path}: cannot be read: {told}'):
        read_parameter_file(path, '/node')


def test_a_file_of_just_a_mebibyte_is_read(tmp_path: Path) -> None:
    (path := tmp_path / 'x.yaml').write_text('#' * MOST_BYTES)
    assert len(read_small_text(path, LinkedPlaneError)) == MOST_BYTES
    path.write_text('#' * (MOST_BYTES + 1))
    with pytest.raises(LinkedPlaneError, match='larger than 1 MiB'):
        read_small_text(path, LinkedPlaneError)
