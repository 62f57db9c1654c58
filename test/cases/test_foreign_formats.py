# SPDX-License-Identifier: Apache-2.0
"""A file of a format that is not read is named as what it is, with what to do."""

from __future__ import annotations

import gzip
import io
import sqlite3
import zipfile
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from command_line import command_fault, command_output

from linkedplane_ros.recordings.formats import ENDINGS_READ

CSV = b'time,flexion,abduction,rotation\n0.0,0.1,0.2,0.3\n0.1,0.15,0.2,0.3\n'
LFS = b'version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n'


def build_zip(*names: str) -> bytes:
    """Return a ZIP archive with files of these names."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, 'w') as archive:
        for name in names:
            archive.writestr(name, 'x')
    return buffer.getvalue()


def build_npz() -> bytes:
    """Return NumPy's archive of arrays, by NumPy itself."""
    buffer = io.BytesIO()
    np.savez(buffer, time=np.zeros(3))
    return buffer.getvalue()


def build_sqlite() -> bytes:
    """Return a database, by SQLite itself."""
    with closing(sqlite3.connect(':memory:')) as database:
        database.execute('CREATE TABLE t (x)')
        return database.serialize() if hasattr(database, 'serialize') else b'SQLite format 3\0'


CASES = {
    'ext_messages/a.trc': ('a TRC file; it has positions of markers', '.mot'),
    'ext_messages/a.txt': ('text by its ending', 'rename it to .csv'),
    'ext_messages/a.c3d': ('a C3D file', 'export joint angles as .csv'),
    'ext_messages/a.mat': ('a MATLAB file', 'save it as .csv'),
    'head_vicon_motive/vicon.csv': ('a Vicon export', 'several rows of names'),
    'head_vicon_motive/motive.csv': ('a Motive (OptiTrack) export', 'several rows of names'),
    'mcap_zst_file/a.mcap.zstd': ('compressed as a whole (Zstandard)', 'zstd -d '),
    'mcap_crash/lfs.mcap': ('a Git LFS pointer', 'git lfs pull'),
}


@pytest.mark.parametrize('name', CASES)
def test_a_case_is_named_as_what_it_is_with_what_to_do(
    capsys: pytest.CaptureFixture[str], cases: Path, tmp_path: Path, name: str
) -> None:
    line = command_fault(capsys, 'process', cases / name, tmp_path / 'o.csv')
    assert f'{cases / name}: {CASES[name][0]}' in line
    assert CASES[name][1] in line
    assert not (tmp_path / 'o.csv').exists()


SIBLINGS = {  # the beginnings are those that `file` (libmagic) and the formats' own papers tell
    'a.bvh': (b'HIERARCHY\nROOT Hips\n{\n', 'a BVH file'),
    'a.amc': (b'#!OML:ASF F:\\a.ASF\n:FULLY-SPECIFIED\n', 'an ASF/AMC file'),
    'a.bag': (b'#ROSBAG V2.0\nE\0\0\0', 'a ROS 1 bag; convert it with rosbags-convert'),
    'a.xlsx': (build_zip('[Content_Types].xml', 'xl/workbook.xml'), 'an Excel workbook'),
    'a.ods': (build_zip('mimetype', 'content.xml'), 'an OpenDocument file'),
    'a.npz': (build_npz(), 'a NumPy file'),
    'a.zip': (build_zip('raise.csv'), 'an archive (ZIP'),
    'a.csv.gz': (gzip.compress(CSV), 'compressed as a whole (gzip)'),
    'a.h5': (b'\x89HDF\r\n\x1a\n\0', 'an HDF5 file'),
    'a.parquet': (b'PAR1\x15\x04\x15', 'a Parquet file'),
    'a.json': (b'{"time": [0.0]}', 'a JSON file'),
    'a.pcapng': (b'\n\r\r\n\x1c\0\0\0M<+\x1a', 'a network capture'),
    'a.png': (b'\x89PNG\r\n\x1a\n', 'an image'),
    'qualisys.tsv': (b'NO_OF_FRAMES\t100\nNO_OF_CAMERAS\t8\n', 'a Qualisys export'),
    'dot.csv': (b'sep=,\nDeviceTag:,D422\nPacketCounter,SampleTimeFine\n', 'an Xsens export'),
    'visual3d.csv': (b'\tC:\\raise.c3d\tC:\\raise.c3d\n', 'a Visual3D export'),
    'again.csv': (b'Joints,,\n100,,\n,,P:Arm,\n', 'a Vicon export'),
    'old.csv': (b'TRAJECTORIES\r\n100,Hz\r\n,*110,,\r\n', 'a Vicon export'),
    'quoted.csv': (b'"Format Version";"1.23"\n', 'a Motive (OptiTrack) export'),
    'topic.csv': (b'header:\n  stamp:\n    sec: 1\n', 'text of ros2 topic echo'),
    'raw.csv': (b'\n<!DOCTYPE html>\n<html>', 'a page of the web'),
    'recording.csv': (b'\x89MCAP0\r\n\1', 'an MCAP recording by its content; rename it'),
    'recording.mcap': (build_sqlite(), 'an SQLite database by its content; rename it'),
    'book.csv': (build_zip('xl/workbook.xml'), 'an Excel workbook; save it as .csv'),
    'matlab.mot': (b'MATLAB 5.0 MAT-file, Platform: GLNXA64', 'a MATLAB file'),
    'pointer.mot': (LFS, 'a Git LFS pointer'),
    'pointer.db3': (LFS, 'a Git LFS pointer'),
    'part.db3.zstd': (b'\x28\xb5\x2f\xfd\x60', 'compressed as a whole (Zstandard)'),
    'a.rec': (CSV, 'a file of unknown format (.rec)'),
    'recording': (CSV, 'a file of unknown format (its name has no ending)'),
}


@pytest.mark.parametrize('name', SIBLINGS)
def test_content_counts_before_the_ending(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str
) -> None:
    content, what = SIBLINGS[name]
    (tmp_path / name).write_bytes(content)
    line = command_fault(capsys, 'process', tmp_path / name, tmp_path / 'o.csv')
    assert f'{tmp_path / name}: {what}' in line
    assert f'(formats that are read: bags, {", ".join(ENDINGS_READ)})' in line
    assert len(line) < 400 + len(str(tmp_path)) * 2


def test_a_bag_of_pointers_is_named(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    bag = tmp_path / 'bag'
    bag.mkdir()
    (bag / 'metadata.yaml').write_text('rosbag2_bagfile_information:\n  version: 9\n')
    (bag / 'bag_0.mcap').write_bytes(LFS)
    for command in (['process', bag, tmp_path / 'o.csv'], ['play', bag]):
        line = command_fault(capsys, *command)
        assert f'{bag / "bag_0.mcap"}: a Git LFS pointer, not the file itself' in line


def test_a_table_is_not_played_and_says_so(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / 'raise.csv').write_bytes(CSV)
    line = command_fault(capsys, 'play', tmp_path / 'raise.csv')
    assert 'raise.csv: a table, not a bag (formats that are read: bags, .mcap, .db3)' in line


def test_what_names_look_like_does_not_make_a_table_foreign(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    # names that begin as other formats do: a table all the same
    for k, name in enumerate(('PAR1', 'BZh9', 'GIF8', 'MATLAB', 'Joints', 'HIERARCHY', '{x')):
        table = tmp_path / f'{k}.csv'
        table.write_bytes(f'{name},time,flexion,abduction,rotation\n1,0,0.1,0.2,0.3\n'.encode())
        assert '1 frames' in command_output(capsys, 'process', table, tmp_path / f'{k}_o.csv')
