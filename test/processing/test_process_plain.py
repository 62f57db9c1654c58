# SPDX-License-Identifier: Apache-2.0
"""Tables that begin with their header, and the file beside them that has their facts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from bags import (
    exit_status,
    odd_motion,
    refusal_line,
    write_bag,
)
from optional import requires

from linkedplane_ros.errors import RecordingError
from linkedplane_ros.processing.reading import read_processed


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
