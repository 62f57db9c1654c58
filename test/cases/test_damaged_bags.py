# SPDX-License-Identifier: Apache-2.0
"""A bag that is cut or damaged is read as far as it is whole, with a word; never read wrongly.

The `mcap` library writes the files and judges what is whole in them; the values are those written.
"""

from __future__ import annotations

import random
import struct
from contextlib import closing
from pathlib import Path

import pytest
from bag_fuzz import (
    COUNT,
    FORMATS,
    LZ4,
    PLAIN,
    ZSTD,
    encode_frame,
    fuzz,
    read_table,
    write_mcap,
    write_sqlite,
    written_frames,
)
from bags import STORE, Sent, exit_status, joint_state, refusal_line, write_bag
from optional import requires

from linkedplane_ros.errors import RecordingError
from linkedplane_ros.processing.reading import read_processed
from linkedplane_ros.recordings.bags.opening import open_bag

pytestmark = requires('mcap', 'zstandard')  # writes and judges the files


def count_whole(path: Path) -> int:
    """Return how many messages the mcap library reads as they were written before it stops."""
    from mcap.exceptions import McapError
    from mcap.reader import NonSeekingReader
    from zstandard import ZstdError

    written = {encode_frame(k)[1] for k in range(COUNT)}
    count = 0
    with path.open('rb') as file:
        try:
            for _, _, message in NonSeekingReader(file, True).iter_messages(log_time_order=False):
                count += bytes(message.data) in written
        except (McapError, ValueError, struct.error, RuntimeError, ZstdError):
            pass
    return count


def record_borders(path: Path) -> list[int]:
    """Return where the records of a file end, by the mcap library."""
    from mcap.stream_reader import StreamReader

    with path.open('rb') as file:
        reader = StreamReader(file, emit_chunks=True)
        return [file.tell() for _ in reader.records]


def read_cut(content: bytes, folder: Path) -> tuple[int, int]:
    """Return how many messages of a file are read, and how many the mcap library reads."""
    path = folder / 'cut.mcap'
    path.write_bytes(content)
    whole = count_whole(path)
    try:
        opened = open_bag(path)
    except RecordingError:
        return 0, whole
    with closing(opened) as bag:
        read = [(message.time, message.data) for message in bag.messages()]
        assert f'ended without a footer, {len(read)} messages' in bag.faults[0]
    assert [data for _, data in read] == [encode_frame(k)[1] for k in range(len(read))]
    return len(read), whole


LAYOUTS = [(PLAIN, True), (ZSTD, True), (LZ4, True), (PLAIN, False)]
NAMES = ['chunks', 'zstd', 'lz4', 'no chunks']


@pytest.mark.parametrize(('compression', 'chunks'), LAYOUTS, ids=NAMES)
def test_a_file_that_is_cut_is_read_as_far_as_the_mcap_library_reads_it(
    tmp_path: Path, compression: str, chunks: bool
) -> None:
    path = write_mcap(tmp_path / 'a.mcap', compression, True, chunks)
    content = path.read_bytes()
    places = random.Random(17).sample(range(8, len(content) - 8), 50)
    for place in (*record_borders(path)[:-1], *places):
        read, whole = read_cut(content[:place], tmp_path)
        assert read == whole, place
        read, whole = read_cut(content[:place] + bytes(4096), tmp_path)
        assert whole - (not chunks) <= read <= whole, f'{place}, then zeros'


def test_the_crashed_recording_gives_its_ten_frames_with_a_warning(
    cases: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / 'o.csv'
    assert exit_status([str(cases / 'mcap_crash' / 'a.mcap'), str(target)]) == 0
    assert len(read_table(target)) == 10
    warning = 'ended without a footer, 10 messages to 0.09 s are whole'
    assert f'warning: {cases / "mcap_crash" / "a.mcap"}: {warning}' in ''.join(capsys.readouterr())
    assert f'# damage: {warning}' in target.read_text()


def flipped(path: Path, place: int) -> Path:
    """Flip a bit of a file."""
    content = bytearray(path.read_bytes())
    content[place] ^= 4
    path.write_bytes(content)
    return path


def test_a_chunk_whose_crc_is_wrong_is_left_out_and_its_messages_are_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_mcap(tmp_path / 'a.mcap', PLAIN, True)
    borders = record_borders(path)
    flipped(path, borders[5] - 100)  # in the third chunk: each has an index behind it
    target = tmp_path / 'o.csv'
    assert exit_status([str(path), str(target)]) == 0
    printed = ''.join(capsys.readouterr())
    frames = read_table(target)
    lost = COUNT - len(frames)
    assert 0 < lost < 10
    assert set(frames) <= set(written_frames().items())
    assert 'its CRC is not that of its bytes' in printed
    assert f'{lost} refused as missing' in printed


def test_zeros_behind_a_chunk_that_is_left_out_are_the_end(tmp_path: Path) -> None:
    path = write_mcap(tmp_path / 'a.mcap', PLAIN, True)
    head = path.read_bytes()[: record_borders(path)[0]]
    path.write_bytes(head + b'\6' + (40).to_bytes(8, 'little') + b'\xff' * 39 + bytes(101))
    with pytest.raises(RecordingError, match=r'no message before is whole: byte \d+: 0'):
        open_bag(path)


def noted(path: Path) -> str:
    """Return the faults of a bag of which all is read."""
    with closing(open_bag(path)) as bag:
        assert len(list(bag.messages())) == COUNT
        bag.check()
        return ' '.join(bag.faults)


def test_a_flip_in_the_summary_is_noticed_by_its_crc(tmp_path: Path) -> None:
    path = write_mcap(tmp_path / 'a.mcap', PLAIN, True)
    flipped(path, path.stat().st_size - 120)
    assert 'the CRC of its summary is not that of its bytes' in noted(path)


def test_a_flip_outside_of_chunks_is_noticed_by_the_crc_of_the_data(tmp_path: Path) -> None:
    path = write_mcap(tmp_path / 'a.mcap', PLAIN, True)
    flipped(path, 30)  # the name of the library in the header
    assert 'the CRC of its data is not that of the bytes' in noted(path)


def test_a_flip_in_a_message_that_only_the_crc_of_the_data_guards_is_refused(
    tmp_path: Path,
) -> None:
    path = write_mcap(tmp_path / 'a.mcap', PLAIN, True, chunks=False)
    flipped(path, record_borders(path)[20] - 10)
    with pytest.raises(ValueError, match='CRC of its data is not that of the bytes, and nothing'):
        noted(path)


@pytest.mark.parametrize('cut', [False, True], ids=['a page overwritten', 'cut short'])
def test_a_damaged_database_is_refused_with_the_way_to_what_is_whole(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], cut: bool
) -> None:
    path = write_sqlite(tmp_path / 'a.db3')
    content = bytearray(path.read_bytes())
    if cut:
        del content[-5000:]
    else:
        content[8192:12288] = b'\xff' * 4096
    path.write_bytes(content)
    assert exit_status([str(path), str(tmp_path / 'o.csv')]) == 1
    error = capsys.readouterr().err
    assert f'`sqlite3 {path} .recover | sqlite3 recovered.db3`' in error
    assert ('cut short' in error) == cut


@pytest.mark.parametrize('name', FORMATS)
def test_an_intact_bag_is_read_without_a_word(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    path = FORMATS[name][0](tmp_path / ('a.db3' if name == 'sqlite3' else 'a.mcap'))
    target = tmp_path / 'o.csv'
    assert exit_status([str(path), str(target)]) == 0
    printed = ''.join(capsys.readouterr())
    assert 'warning' not in printed
    assert 'refused' not in printed
    assert read_table(target) == list(written_frames().items())


def test_no_damaged_bag_is_read_differently_without_a_word(tmp_path: Path) -> None:
    verdicts, faults = fuzz(40, 17, tmp_path)  # 1,000 of them in `make soak`
    assert faults == []
    assert verdicts.total() == 40


def cut_message(sent: Sent, size: int) -> Sent:
    """Return a message of which only the first bytes are left."""
    return *sent[:3], sent[3][:size]


@pytest.mark.parametrize('size', [0, 2, 4, 6, 12, 30])
def test_a_message_that_is_cut_is_a_refused_frame(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], size: int
) -> None:
    sent = [joint_state(k) for k in range(10)]
    sent[5] = cut_message(sent[5], size)
    bag = write_bag(tmp_path / 'bag', sent)
    assert exit_status([str(bag), str(tmp_path / 'o.csv')]) == 0
    assert len(read_table(tmp_path / 'o.csv')) == 9
    line = (
        f'1 refused as damaged, first at message 6, 0.05 s: damaged: its {size} bytes are no '
        'whole sensor_msgs/msg/JointState\n'
    )
    assert line in capsys.readouterr().out
    assert exit_status([str(bag), str(tmp_path / 'out')]) == 0  # with the message as it is
    with closing(open_bag(tmp_path / 'out')) as written:
        assert cut_message(sent[5], size)[3] in [message.data for message in written.messages()]
    line = refusal_line_of_plot(tmp_path / 'out')
    assert line == (
        f'{tmp_path / "out"}: a message on /joint_states is damaged: its {size} bytes are no '
        'whole sensor_msgs/msg/JointState'
    )


def refusal_line_of_plot(path: Path) -> str:
    """Return why a processed recording is not drawn."""
    with pytest.raises(RecordingError) as caught:
        read_processed(path)
    return str(caught.value)


def test_a_bag_of_which_most_messages_are_cut_ends_with_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sent = [cut_message(joint_state(k), 30 if k < 6 else 10**6) for k in range(10)]
    assert exit_status([str(write_bag(tmp_path / 'bag', sent)), str(tmp_path / 'o.csv')]) == 1
    assert 'most frames were refused' in capsys.readouterr().err
    sent = [cut_message(joint_state(k), 30) for k in range(10)]
    line = refusal_line(capsys, str(write_bag(tmp_path / 'none', sent)), str(tmp_path / 'p.csv'))
    assert 'nothing was usable: message 1, 0.00 s: damaged: its 30 bytes' in line


def pose(k: int, topic: str) -> Sent:
    """Return the k-th pose of a bone that does not move."""
    types, kind = STORE.types, 'geometry_msgs/msg/PoseStamped'
    message = types[kind](
        types['std_msgs/msg/Header'](types['builtin_interfaces/msg/Time'](9, k * 10**7), 'lab'),
        types['geometry_msgs/msg/Pose'](
            types['geometry_msgs/msg/Point'](0.0, 0.0, 0.0),
            types['geometry_msgs/msg/Quaternion'](0.0, 0.6, 0.0, 0.8),
        ),
    )
    return topic, kind, 9 * 10**9 + k * 10**7, bytes(STORE.serialize_cdr(message, kind))


@pytest.mark.parametrize('size', [0, 6, 12, 30])
def test_a_pose_that_is_cut_is_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], size: int
) -> None:
    sent = [each for k in range(6) for each in (pose(k, '/scap'), pose(k, '/hum'))]
    sent[4] = cut_message(sent[4], size)
    bag = write_bag(tmp_path / 'bag', sent)
    command = ['--humerus', '/hum', '--scapula', '/scap']
    assert exit_status([str(bag), str(tmp_path / 'o.csv'), *command]) == 0
    assert len(read_table(tmp_path / 'o.csv')) == 5
    assert '1 refused as damaged, first at message 5, 0.02 s: ' in capsys.readouterr().out
