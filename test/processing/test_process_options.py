# SPDX-License-Identifier: Apache-2.0
"""Options and places: which recordings are meant, and where their outputs go."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
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
from optional import requires

from linkedplane_ros.commands.main import main
from linkedplane_ros.errors import RecordingError
from linkedplane_ros.joints.conventions import JOINT_CONVENTIONS, THESIS_CONVENTION
from linkedplane_ros.processing.inputs import find_recordings
from linkedplane_ros.processing.reading import read_processed


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
        (('--rate', '1e13'), 'in: '),
        (('--humerus', '', '--thorax', 'b'), 'a name expected'),
        (('--humerus', '/h', '--scapula', '/s'), '/h is not a topic of'),
        (('--rhythm', '2'), '--thorax'),
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


def test_a_plain_table_begins_with_its_header_and_has_its_facts_beside_it(tmp_path: Path) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    usual, plain = tmp_path / 'usual.csv', tmp_path / 'plain.csv'
    assert exit_status([str(source), str(usual)]) == 0
    assert exit_status([str(source), str(plain), '--plain']) == 0
    assert sorted(each.name for each in tmp_path.iterdir()) == [
        'in', 'plain.csv', 'plain.csv.facts.yaml', 'usual.csv',
    ]  # fmt: skip
    lines = usual.read_text().splitlines()
    table = [line for line in lines if not line.startswith('#')]
    assert plain.read_text().splitlines() == table
    assert table[0].startswith('time,')
    facts = yaml.safe_load((tmp_path / 'plain.csv.facts.yaml').read_text())
    assert [f'# {name}: {fact}' for name, fact in facts.items()] == lines[: -len(table)]
    one, other = read_processed(usual), read_processed(plain)
    assert other.title == one.title.replace('usual.csv', 'plain.csv')
    assert other.heads == one.heads
    np.testing.assert_array_equal(other.arms, one.arms)


def test_the_facts_of_a_plain_table_are_replaced_with_it_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    table, facts = tmp_path / 'out.csv', tmp_path / 'out.csv.facts.yaml'
    facts.write_text('made_by: linkedplane_ros 0.1\nside: left\n')
    line = refusal_line(capsys, str(source), str(table), '--plain')
    assert f'{facts}: exists; --force to replace it' in line
    assert not table.exists()
    assert exit_status([str(source), str(table), '--plain', '--force']) == 0
    assert yaml.safe_load(facts.read_text())['side'] == 'right'
    assert exit_status([str(source), str(table), '--force']) == 0
    assert not facts.exists()  # the facts are in the table again
    assert read_processed(table).bands


@pytest.mark.parametrize(
    'target', ['out.csv', pytest.param('out.parquet', marks=requires('pyarrow')), 'out']
)
def test_a_file_named_as_facts_stays_where_process_did_not_write_it(
    tmp_path: Path, target: str
) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    foreign = tmp_path / f'{target}.facts.yaml'
    foreign.write_text('precious\n')
    assert exit_status([str(source), str(tmp_path / target), '--force']) == 0
    assert foreign.read_text() == 'precious\n'


def test_the_facts_of_another_output_stay_beside_a_bag(tmp_path: Path) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    facts = tmp_path / 'out.facts.yaml'
    facts.write_text('made_by: linkedplane_ros 0.1\n')
    assert exit_status([str(source), str(tmp_path / 'out'), '--force']) == 0
    assert facts.exists()


def test_a_folder_named_as_facts_stays(tmp_path: Path) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    (tmp_path / 'out.csv.facts.yaml').mkdir()
    assert exit_status([str(source), str(tmp_path / 'out.csv'), '--force']) == 0
    assert (tmp_path / 'out.csv.facts.yaml').is_dir()


@pytest.mark.parametrize('folder', [True, False])
@pytest.mark.parametrize('force', [[], ['--force']])
def test_only_facts_are_replaced_by_facts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], folder: bool, force: list[str]
) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    table, foreign = tmp_path / 'out.csv', tmp_path / 'out.csv.facts.yaml'
    if folder:
        foreign.mkdir()
    else:
        foreign.write_text('precious\n')
    line = refusal_line(capsys, str(source), str(table), '--plain', *force)
    assert f'{foreign}: exists, and --plain did not write it: not replaced' in line
    assert not table.exists()
    assert foreign.is_dir() or foreign.read_text() == 'precious\n'


def test_a_failure_leaves_neither_a_plain_table_nor_its_facts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'bad.csv').write_text('time,flexion,abduction,rotation\n0,90,20,30\n')
    refusal_line(capsys, str(tmp_path / 'bad.csv'), str(tmp_path / 'out.csv'), '--plain')
    assert [each.name for each in tmp_path.iterdir()] == ['bad.csv']


@pytest.mark.parametrize('target', ['out', 'out.parquet'])
def test_only_a_csv_can_be_plain(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], target: str
) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    line = refusal_line(capsys, str(source), str(tmp_path / target), '--plain')
    kind = 'parquet' if '.' in target else 'bag'
    assert f'{tmp_path / target}: --plain is for .csv; the output is {kind}' in line


@pytest.mark.parametrize('text', ['[1, 2', 'a word'])
def test_facts_that_cannot_be_read_are_one_line(tmp_path: Path, text: str) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    assert exit_status([str(source), str(tmp_path / 'out.csv'), '--plain']) == 0
    (tmp_path / 'out.csv.facts.yaml').write_text(text)
    with pytest.raises(RecordingError, match=r'out\.csv\.facts\.yaml: not YAML') as caught:
        read_processed(tmp_path / 'out.csv')
    assert '\n' not in str(caught.value)


def test_a_topic_without_messages_is_not_chosen(tmp_path: Path) -> None:
    sent = [('/human/joint_states', *rest) for _, *rest in (joint_state(0), joint_state(1))]
    source = write_bag(tmp_path / 'in', sent, empty=['/joint_states'])
    assert exit_status([str(source), str(tmp_path / 'out.csv')]) == 0
    assert '# topic: /human/joint_states\n' in (tmp_path / 'out.csv').read_text()


def plain_table(folder: Path) -> tuple[Path, Path]:
    """Write a plain table; return it and the file of its facts."""
    source, table = write_bag(folder / 'in', odd_motion()), folder / 'out.csv'
    assert exit_status([str(source), str(table), '--plain']) == 0
    return table, folder / 'out.csv.facts.yaml'


def plot_refusal(table: Path) -> str:
    """Return why an output cannot be read."""
    with pytest.raises(RecordingError) as caught:
        read_processed(table)
    return str(caught.value)


def test_a_plain_table_without_its_facts_says_what_is_missing(tmp_path: Path) -> None:
    table, facts = plain_table(tmp_path)
    facts.unlink()
    assert plot_refusal(table) == f'{table}: out.csv.facts.yaml is not beside it'
    facts.mkdir()
    assert plot_refusal(table) == f'{facts}: cannot be read: Is a directory'


@pytest.mark.parametrize('name', ['muscle', 'side', 'joint_convention', 'heads'])
def test_facts_without_one_that_is_drawn_are_named_with_it(tmp_path: Path, name: str) -> None:
    table, facts = plain_table(tmp_path)
    held = yaml.safe_load(facts.read_text())
    facts.write_text(yaml.safe_dump({each: held[each] for each in held if each != name}))
    assert plot_refusal(table) == f'{facts}: no {name!r} in it'


def test_a_table_of_something_else_is_no_output(tmp_path: Path) -> None:
    (tmp_path / 'a.csv').write_text('time,flexion\n0,1\n')
    line = plot_refusal(tmp_path / 'a.csv')
    assert line == f"{tmp_path / 'a.csv'}: not an output of linkedplane process: no 'muscle' in it"


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
