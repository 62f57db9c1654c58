# SPDX-License-Identifier: Apache-2.0
"""Every block of the README and of the documentation does what it says (blocks.py)."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml
from blocks import Reader, blocks, lay_out
from pages import NAMES, TOP

OWN = 'doc/how_to/your_own_muscle.md'  # read in test_your_own_muscle.py, with its node


@pytest.mark.parametrize('name', [name for name in NAMES if name != OWN and blocks(TOP / name)])
def test_the_blocks_of_a_page_do_what_they_say(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lay_out(tmp_path)
    monkeypatch.chdir(tmp_path)
    Reader(TOP / name).read()


@pytest.mark.parametrize(
    ('block', 'fault'),
    [
        ('```python\nprint(rotations)\n```', "page.md:2: name 'rotations' is not defined"),
        ('```python\n>>> 1 + 1\n3\n```', 'Got:'),
        ('```python\nprint(1)\n```\n\n```text\n2\n```', 'page.md:6: '),
        ('```console\n$ make tea\n```', "'make', '-n', 'tea'"),
        ('```console\n$ ros2 run linkedplane_ros muscle\n```', 'page.md:2: '),
        (
            '```console\n$ muscle_state_publisher --ros-args -p joint_convention:=isb\n```',
            'parameter joint_convention',
        ),
        ('```console\n$ ros2 topic echo /deltoid/lengths\n```', 'page.md:2: '),
        (
            '```console\n$ ros2 topic echo /deltoid/band_states std_msgs/msg/String\n```',
            'page.md:2: ',
        ),
        ('```console\n$ ros2 topic echo --field date /deltoid/band_lengths &\n```', 'page.md:2: '),
        (
            '```console\n$ ros2 run linkedplane_ros muscle_state_publisher --ros-args '
            '-p qos_overrides./deltoid/arms.publisher.durability:=transient_local\n```',
            'page.md:2: ',
        ),
        (
            '```console\n$ ros2 run plotjuggler plotjuggler --layout config/none.xml\n```',
            'page.md:2: ',
        ),
        (
            '```console\n$ ros2 launch linkedplane_ros deltoid.launch.py rvz:=true\n```',
            'page.md:2: ',
        ),
        ("```console\n$ pip install '.[speed]'\n```", 'speed'),
        ('```console\n$ linkedplane solve --convention isb_yxy 0 7 0\n```', 'isb_yxy 0 7 0'),
        ('```console\n$ rm -r everything\n```', 'not known to the tests'),
    ],
)
def test_a_wrong_block_is_found(
    block: str, fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    page = Path('page.md')
    page.write_text(f'{block}\n')
    with pytest.raises(AssertionError) as found:
        Reader(page).read()
    assert fault in str(found.value)


def test_the_answer_that_a_script_gets_is_that_of_the_sample_message() -> None:
    page = TOP / 'doc' / 'how_to' / 'scripts.md'
    [text] = [block.text for block in blocks(page) if block.language == 'text']
    [numbers] = re.findall(r"array\('d', (\[.*\])\)", text)
    sample = TOP / 'msg_examples' / 'abduction_90.expected.yaml'
    expected = yaml.safe_load(sample.read_text(encoding='utf-8'))['band_lengths']
    assert yaml.safe_load(numbers) == pytest.approx(expected, abs=1e-11)  # m: rounded to 1e-12
