# SPDX-License-Identifier: Apache-2.0
"""The formats of recordings that are not read, and what to do with a file of each."""

from __future__ import annotations

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class ForeignFormat:
    """A format that is not read."""

    name: str
    """What a file of it is called in a message."""
    advice: str
    """What to do with {file}."""
    endings: tuple[str, ...] = ()
    content: re.Pattern[bytes] | None = None
    """How such a file begins; None: only the ending of its name tells."""
    within: re.Pattern[str] | None = None
    """How a name in a ZIP archive begins that tells what the archive is."""
    unless: str = ''
    """With this ending, a file of this content is read."""


def begins_with(*beginnings: bytes) -> re.Pattern[bytes]:
    """Return the pattern of the first bytes of a file."""
    return re.compile(b'|'.join(map(re.escape, beginnings)))


def text_begins_with(pattern: bytes) -> re.Pattern[bytes]:
    """Return the pattern of the first words of a text, also as a spreadsheet saves it again."""
    return re.compile(rb'(?:\xef\xbb\xbf)?\s*(?:"?sep=."?\r?\n)?"?' + pattern, re.IGNORECASE)


AS_CSV = 'save it as .csv: a row of names with a time in s, and rows of numbers'
ONE_HEADER = (
    'it has several rows of names; write a .csv of joint angles with one: a time in s, and a '
    'column for each angle'
)
EXPORT = 'export joint angles as .csv, .mot or .sto'
UNPACK = 'unpack it first'
NO_ANGLES = f'it has positions of markers, no joint angles; {EXPORT}, as from inverse kinematics'
MARKER_TREE = f'its joints are a skeleton of its own; {EXPORT}'
RENAME = 'rename it so that it ends in {ending}'

FOREIGN = (
    ForeignFormat(
        'a Git LFS pointer, not the file itself',
        'fetch that with git lfs pull',
        content=text_begins_with(rb'version https://git-lfs\.github\.com/spec/'),
    ),
    ForeignFormat(
        'compressed as a whole (Zstandard)',
        'decompress it first: zstd -d {file}',
        ('.zst', '.zstd'),
        begins_with(b'\x28\xb5\x2f\xfd'),
    ),
    ForeignFormat(
        'compressed as a whole (LZ4)',
        'decompress it first: lz4 -d {file}',
        ('.lz4',),
        begins_with(b'\x04\x22\x4d\x18'),
    ),
    ForeignFormat(
        'compressed as a whole (gzip)',
        'decompress it first: gunzip {file}',
        ('.gz', '.tgz'),
        begins_with(b'\x1f\x8b'),
    ),
    ForeignFormat(
        'compressed as a whole (bzip2)',
        'decompress it first: bunzip2 {file}',
        ('.bz2',),
        re.compile(rb'BZh[1-9](?:1AY&SY|\x17\x72\x45\x38)'),
    ),
    ForeignFormat(
        'compressed as a whole (xz)',
        'decompress it first: unxz {file}',
        ('.xz',),
        begins_with(b'\xfd7zXZ\0'),
    ),
    ForeignFormat(
        'an Excel workbook', AS_CSV, ('.xlsx', '.xlsm', '.xlsb'), within=re.compile('xl/')
    ),
    ForeignFormat(
        'an Excel workbook', AS_CSV, ('.xls',), begins_with(b'\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1')
    ),
    ForeignFormat('an OpenDocument file', AS_CSV, ('.ods', '.fods'), within=re.compile('mimetype')),
    ForeignFormat(
        'an Apple Numbers spreadsheet', AS_CSV, ('.numbers',), within=re.compile('Index/')
    ),
    ForeignFormat(
        'an archive (tar)', UNPACK, ('.tar',), re.compile(rb'.{257}ustar', re.DOTALL)
    ),
    ForeignFormat('an archive (7z)', UNPACK, ('.7z',), begins_with(b"7z\xbc\xaf'\x1c")),
    ForeignFormat('an archive (RAR)', UNPACK, ('.rar',), begins_with(b'Rar!\x1a\x07')),
    ForeignFormat(
        'a NumPy file', AS_CSV, ('.npy', '.npz'), begins_with(b'\x93NUMPY'),
        within=re.compile(r'.*\.npy$'),
    ),
    ForeignFormat(
        'an archive (ZIP; a workbook is one, too)', UNPACK, ('.zip',),
        begins_with(b'PK\3\4', b'PK\5\6'),
    ),
    ForeignFormat('a MATLAB file', AS_CSV, ('.mat',), begins_with(b'MATLAB 5.0', b'MATLAB 7.3')),
    ForeignFormat(
        'an HDF5 file', AS_CSV, ('.h5', '.hdf5', '.hdf'), begins_with(b'\x89HDF\r\n\x1a\n')
    ),
    ForeignFormat('a Parquet file', AS_CSV, ('.parquet',), re.compile(rb'PAR1[\x00-\x1f]')),
    ForeignFormat('an Arrow file', AS_CSV, ('.arrow', '.feather'), begins_with(b'ARROW1\0')),
    ForeignFormat('a Python pickle', AS_CSV, ('.pkl', '.pickle'), re.compile(rb'\x80[\x02-\x05]')),
    ForeignFormat(
        'a ROS 1 bag',
        'convert it with rosbags-convert first (rosbags-convert --src {file} --dst FOLDER)',
        ('.bag',),
        begins_with(b'#ROSBAG V'),
    ),
    ForeignFormat(
        'an MCAP recording by its content', RENAME, content=begins_with(b'\x89MCAP0\r\n'),
        unless='.mcap',
    ),
    ForeignFormat(
        'an SQLite database by its content', RENAME, content=begins_with(b'SQLite format 3\0'),
        unless='.db3',
    ),
    ForeignFormat('a ULog of PX4', AS_CSV, ('.ulg',), begins_with(b'ULog\x01\x12\x35')),
    ForeignFormat(
        'a C3D file', f'it has markers and forces; {EXPORT}', ('.c3d',), begins_with(b'\2P')
    ),
    ForeignFormat('a TRC file', NO_ANGLES, ('.trc',), text_begins_with(rb'PathFileType')),
    ForeignFormat(
        'a BVH file', MARKER_TREE, ('.bvh',), text_begins_with(rb'HIERARCHY\s+(?:ROOT|//)')
    ),
    ForeignFormat(
        'an ASF/AMC file', MARKER_TREE, ('.amc', '.asf'), text_begins_with(rb'#!OML:ASF')
    ),
    ForeignFormat('an FBX file', MARKER_TREE, ('.fbx',), begins_with(b'Kaydara FBX Binary')),
    ForeignFormat(
        'a Motive (OptiTrack) export',
        f'it has poses of rigid bodies or markers, and {ONE_HEADER}',
        ('.tak',),
        text_begins_with(rb'Format Version"?[,;\t]'),
    ),
    ForeignFormat(
        'a Vicon export',
        f'it counts frames, not time, and {ONE_HEADER}',
        ('.x1d', '.x2d', '.vsk'),
        text_begins_with(
            rb'(?:Model Outputs|Trajectories|Analog|Devices|Joints|Segments|Events)["\s,;]*\n'
            rb'"?\d+(?:[.,]\d+)?["\s,;]*(?:Hz["\s,;]*)?\n'
        ),
    ),
    ForeignFormat(
        'a Qualisys export', ONE_HEADER, ('.qtm',), text_begins_with(rb'NO_OF_(?:FRAMES|CAMERAS)\b')
    ),
    ForeignFormat(
        'an Xsens export',
        ONE_HEADER,
        ('.mvn', '.mvnx'),
        text_begins_with(
            rb'(?:DeviceTag:|// ?(?:General information|Start Time|Update Rate|DeviceId))'
        ),
    ),
    ForeignFormat(
        'a Visual3D export',
        ONE_HEADER,
        ('.cmo', '.cmz'),
        re.compile(rb'(?:\xef\xbb\xbf)?\t[^\r\n]*\.c3d\b', re.IGNORECASE),
    ),
    ForeignFormat(
        'text of ros2 topic echo',
        'record with ros2 bag record',
        content=text_begins_with(rb'header:\s*\n\s+stamp:\s*\n'),
    ),
    ForeignFormat(
        'a page of the web',
        'download the file itself (the "raw" one)',
        ('.html', '.htm'),
        text_begins_with(rb'(?:<!doctype html|<html)'),
    ),
    ForeignFormat(
        'an XML file', EXPORT, ('.xml', '.osim', '.urdf'),
        text_begins_with(rb'<(?:\?xml|\w+Document)\b'),
    ),
    ForeignFormat(
        'a JSON file', AS_CSV, ('.json', '.jsonl', '.ndjson'),
        text_begins_with(rb'(?:\{\s*"|\[\s*[\[{])'),
    ),
    ForeignFormat('a YAML file', EXPORT, ('.yaml', '.yml')),
    ForeignFormat(
        'a network capture', 'record with ros2 bag record', ('.pcap', '.pcapng'),
        re.compile(
            rb'\xd4\xc3\xb2\xa1|\xa1\xb2\xc3\xd4|\x4d\x3c\xb2\xa1|\xa1\xb2\x3c\x4d|'
            rb'\n\r\r\n.{4}(?:\x4d\x3c\x2b\x1a|\x1a\x2b\x3c\x4d)', re.DOTALL
        ),
    ),
    ForeignFormat(
        'an image', EXPORT, ('.png', '.jpg', '.jpeg', '.gif', '.tif', '.tiff', '.svg', '.bmp'),
        re.compile(rb'\x89PNG\r\n|\xff\xd8\xff|GIF8[79]a|II\x2a\0|MM\0\x2a'),
    ),
    ForeignFormat(
        'a video', EXPORT, ('.mp4', '.avi', '.mov', '.mkv'),
        re.compile(rb'\0\0.{2}ftyp|RIFF.{4}AVI |\x1aE\xdf\xa3', re.DOTALL),
    ),
    ForeignFormat('a PDF document', EXPORT, ('.pdf',), begins_with(b'%PDF-')),
    ForeignFormat(
        'text by its ending',
        'if it is a table, rename it to .csv (cells apart by commas, semicolons or tabs), '
        '.mot or .sto',
        ('.txt', '.dat', '.asc', '.log', '.prn'),
    ),
)  # fmt: skip
