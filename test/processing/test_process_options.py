# SPDX-License-Identifier: Apache-2.0
"""Options and places: which recordings are meant, and where their outputs go."""

from __future__ import annotations

from pathlib import Path

import pytest
from bags import (
    BAG,
    exit_status,
    joint_state,
    odd_motion,
    read_messages,
    refusal_line,
    text_note,
    write_bag,
)

from linkedplane_ros.commands.main import main
from linkedplane_ros.joints.conventions import JOINT_CONVENTIONS, THESIS_CONVENTION
from linkedplane_ros.processing.inputs import find_recordings


def test_an_output_that_exists_is_left_alone_without_force(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / 'out.csv'
    out.write_text('precious')
    assert '--force' in refusal_line(capsys, str(BAG), str(out))
    assert out.read_text() == 'precious'
    assert exit_status([str(BAG), str(out), '--force']) == 0
    assert out.read_text() != 'precious'


def test_a_recording_is_not_its_own_output(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / 'in.csv'
    source.write_text('time,flexion,abduction,rotation\n0,0.1,0.2,0.3\n')
    before = source.read_bytes()
    assert 'is, holds or lies in the recording' in refusal_line(
        capsys, str(source), str(source), '--force'
    )
    assert source.read_bytes() == before


def test_a_folder_that_is_no_bag_is_not_replaced(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'arm_raise').mkdir()
    (tmp_path / 'arm_raise' / 'thesis.txt').write_text('precious')
    line = refusal_line(capsys, str(BAG), str(BAG.parent), str(tmp_path), '--force')
    assert 'a folder; only a bag is replaced' in line
    assert (tmp_path / 'arm_raise' / 'thesis.txt').read_text() == 'precious'


@pytest.mark.parametrize('kind', ['csv', 'bag'])
def test_force_does_not_replace_the_folder_that_the_source_lies_in(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    bag = write_bag(tmp_path / 'rec', odd_motion())
    inner = bag / 'rec.mcap'
    before = inner.read_bytes()
    refusal_line(capsys, str(inner), str(bag), '--force', '--format', kind)
    refusal_line(capsys, str(BAG), str(bag), '--force', '--format', 'csv')
    assert inner.read_bytes() == before


def test_a_bag_is_replaced_by_a_bag_with_force(tmp_path: Path) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    target = write_bag(tmp_path / 'old', [text_note(0)])
    assert exit_status([str(source), str(target), '--force']) == 0
    assert {topic for topic, *_ in read_messages(target)} >= {
        '/joint_states',
        '/deltoid/band_states',
    }


@pytest.mark.parametrize(
    ('options', 'word'),
    [
        (('--joints', 'flexion', 'flexion', 'rotation'), '3 different joints'),
        (('--offsets', 'nan', '0', '0'), 'finite numbers expected'),
        (('--offsets', '1e17', '0', '0'), 'a full turn at most expected, |offset| <= 2 pi rad'),
        (('--offsets', '0', '0', '-6.2832'), 'a full turn at most expected'),
        (('--frame-id', 'a b\n'), "--frame-id: 'a b\\n' given (4 characters), at most 255"),
        (('--frame-id', 256 * 'f'), '(256 characters), at most 255 characters that print'),
        (('--frame-id', '/scapula'), "tf2 has none that starts with '/'"),
        (('--rate', '1e13'), 'in: '),
        (('--humerus', '', '--thorax', 'b'), 'a name expected'),
        (('--humerus', '/h', '--scapula', '/s'), '/h is not a topic of'),
        (('--rhythm', '2', '--scapula', 's', '--humerus', 'h'), '--rhythm: not with the pose of'),
        (('--rest', 'still'), '--thorax'),
        (('--rhythm', '2', '--rest', '32', '10.7', '-10.3'), '--rest: scapula: (32.0, 10.7, -10.3'),
        (('--humerus', 'h', '--scapula', 'h'), "frame 'h' given for scapula and humerus; a frame"),
        (
            ('--input', 'tf', '--bone-links', 'humerus:=f', 'scapula:=f'),
            "frame 'f' given for scapula and humerus; a frame of its own expected",
        ),
        (('--rhythm', '2', '--skeleton', 'hip'), '--skeleton: a rhythm stands for the joints'),
        (('--joints', 'a', 'b', 'c', '--skeleton', 'hip'), '--joints: not with --skeleton'),
        (('--joint-names', 'a:=b'), '--joint-names: only with the joints of a --skeleton'),
        (('--clavicle', 'c'), '--clavicle NAME goes with --humerus NAME and --scapula NAME'),
        (('--bone-links', 'a:=b'), '--bone-links: only with --skeleton or --input tf'),
        (('--input', 'tf', '--rate', '50', '--skeleton', 'hip'), '--rate: only for angles'),
        (('--input', 'joint_states', '--humerus', 'h', '--scapula', 's'), 'joints have no frames'),
        (('--topic', '/other'), 'on /other'),
    ],
)
def test_odd_options_are_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], word: str
) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    assert word in refusal_line(capsys, str(source), str(tmp_path / 'out.csv'), *options)


def test_patterns_are_matched_where_the_shell_has_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for k in range(3):
        write_bag(tmp_path / f'walk_{k}', odd_motion())
    command = [str(tmp_path / 'walk_*'), str(tmp_path / 'out'), '--format', 'csv']
    assert exit_status(command) == 0
    assert '3 of 3 recordings' in capsys.readouterr().out
    assert 'run_*: nothing matches' in refusal_line(capsys, str(tmp_path / 'run_*'), 'out')


def test_folders_with_a_dot_in_their_names_keep_them(tmp_path: Path) -> None:
    sources = [write_bag(tmp_path / f'walk.0{k}', odd_motion()) for k in (1, 2)]
    assert exit_status([*map(str, sources), str(tmp_path / 'out')]) == 0
    assert sorted(each.name for each in (tmp_path / 'out').iterdir()) == ['walk.01', 'walk.02']


def test_a_bag_is_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = refusal_line(capsys, str(BAG), str(tmp_path / 'out.mcap'))
    assert f'{tmp_path / "out.mcap"}: a bag is a folder; name it without .mcap' in line


def test_a_pattern_stands_for_the_recordings_in_it(tmp_path: Path) -> None:
    write_bag(tmp_path / 'lab' / 'deep' / 'walk', odd_motion())
    (tmp_path / 'lab' / 'notes.txt').touch()
    assert exit_status([str(tmp_path / 'lab' / '**'), str(tmp_path / 'out')]) == 0
    assert [each.name for each in (tmp_path / 'out').iterdir()] == ['walk']


def test_several_recordings_need_a_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sources = [str(write_bag(tmp_path / f'in{k}', odd_motion())) for k in range(2)]
    line = refusal_line(capsys, *sources, str(tmp_path / 'x.csv'))
    assert 'x.csv: a folder expected for several recordings; --format csv?' in line


@pytest.mark.parametrize(
    ('options', 'line'),
    [
        (('--joints', 'a', 'b', 'c'), '--joints: only for joint angles, not for poses'),
        (('--signs', '1', '-1', '1'), '--signs: only for joint angles, not for poses'),
        (('--degrees',), '--degrees: only for joint angles, not for poses'),
    ],
)
def test_options_that_would_do_nothing_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], line: str
) -> None:
    poses = ('--humerus', '/h', '--scapula', '/s')
    assert line in refusal_line(capsys, str(BAG), str(tmp_path / 'out'), *poses, *options)
    assert '--frame-axes: only for poses' in refusal_line(
        capsys, str(BAG), str(tmp_path / 'out'), '--frame-axes', 'isb'
    )


def test_a_file_is_not_replaced_by_a_bag(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'out').touch()
    line = refusal_line(capsys, str(BAG), str(tmp_path / 'out'), '--force')
    assert f'{tmp_path / "out"}: a file; a bag is a folder' in line


def test_a_folder_holds_bags_and_tables_in_the_order_of_their_names(tmp_path: Path) -> None:
    write_bag(tmp_path / 'b', [joint_state(0)])
    for name in ('c.mot', 'a.sto', 'notes.txt', 'd.CSV'):
        (tmp_path / name).touch()
    found, faults = find_recordings([str(tmp_path)])
    assert ([each.name for each in found], faults) == (['a.sto', 'b', 'c.mot', 'd.CSV'], [])


def test_a_topic_without_messages_is_not_chosen(tmp_path: Path) -> None:
    sent = [('/human/joint_states', *rest) for _, *rest in (joint_state(0), joint_state(1))]
    source = write_bag(tmp_path / 'in', sent, empty=['/joint_states'])
    assert exit_status([str(source), str(tmp_path / 'out.csv')]) == 0
    assert '# topic: /human/joint_states\n' in (tmp_path / 'out.csv').read_text()


@pytest.mark.parametrize(
    ('convention', 'against'),
    [
        ('opensim_mobl', 'thorax'),
        ('rep155', 'torso'),
        ('isb_yxy', ''),
        (THESIS_CONVENTION.name, ''),
    ],
)
def test_a_convention_of_the_thorax_is_warned_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], convention: str, against: str
) -> None:
    coordinates = JOINT_CONVENTIONS[convention].coordinates
    (tmp_path / 'in.csv').write_text(f'time,{",".join(coordinates)}\n0,0.1,0.2,0.3\n')
    files = str(tmp_path / 'in.csv'), str(tmp_path / 'out.csv')
    assert main(['process', *files, '--convention', convention]) == 0
    warning = (
        f'linkedplane: {convention} streams usually measure the humerus against the {against}; '
        'the model needs it against the scapula\n'
    )
    assert capsys.readouterr().err == (warning if against else '')
