# SPDX-License-Identifier: Apache-2.0
"""What is no skeleton is refused in one line that names the file, the part and the reason."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from random_urdfs import joint, link, robot

import linkedplane_ros
from linkedplane_ros import Skeleton, SkeletonError

AB = link('a') + link('b')
ABC = AB + link('c')


def hinge(inside: str, kind: str = 'revolute') -> str:
    return robot(AB, joint('j', kind, 'a', 'b', inside))


NO_TREES = {
    'loop of two parents': (
        robot(ABC, *(joint(*each) for each in (
            ('p', 'fixed', 'a', 'b'), ('q', 'fixed', 'a', 'c'), ('r', 'fixed', 'b', 'c'),
        ))),
        "link 'c': the child of joints 'q' and 'r', a loop; a tree expected",
    ),
    'no root': (
        robot(AB, joint('p', 'fixed', 'a', 'b'), joint('q', 'fixed', 'b', 'a')),
        'joints p, q form a loop; a tree expected',
    ),
    'a loop beside a root': (
        robot(ABC, joint('p', 'fixed', 'c', 'b'), joint('q', 'fixed', 'b', 'c')),
        'joints p, q form a loop; a tree expected',
    ),
    'a link on itself': (
        robot(AB, joint('p', 'fixed', 'b', 'b')),
        "joint 'p': parent and child are both 'b'",
    ),
    'several roots': (
        robot(ABC, joint('p', 'fixed', 'a', 'b')),
        '2 links without a parent, a, c; one root expected',
    ),
    'unknown type': (hinge('', 'hinge'), "joint 'j': type 'hinge' is not known; revolute, "),
    'capital type': (hinge('', 'Revolute'), "joint 'j': type 'Revolute' is not known; revolute, "),
    'no type': (
        robot(AB, '<joint name="j"><parent link="a"/><child link="b"/></joint>'),
        "joint 'j': has no type; revolute, continuous, prismatic, fixed expected",
    ),
    'floating': (hinge('', 'floating'), "joint 'j': type 'floating' has six coordinates; revolute"),
    'planar': (hinge('', 'planar'), "joint 'j': type 'planar' has three coordinates; revolute"),
    'a parent that is not there': (
        robot(AB, joint('j', 'fixed', 'x', 'b')),
        "joint 'j': its parent 'x' is no link of it",
    ),
    'a child that is not there': (
        robot(AB, joint('j', 'fixed', 'a', 'x')),
        "joint 'j': its child 'x' is no link of it",
    ),
    'no parent': (
        robot(AB, '<joint name="j" type="fixed"><child link="b"/></joint>'),
        "joint 'j': has no parent link",
    ),
    'no child': (
        robot(AB, '<joint name="j" type="fixed"><parent link="b"/></joint>'),
        "joint 'j': has no child link",
    ),
    'a link twice': (robot(AB, link('a')), "link 'a': given twice; names that differ expected"),
    'a joint twice': (
        robot(ABC, joint('j', 'fixed', 'a', 'b'), joint('j', 'fixed', 'a', 'c')),
        "joint 'j': given twice; names that differ expected",
    ),
    'a link without a name': (robot('<link/>'), 'link 0: has no name'),
    'a joint without a name': (robot(AB, joint('', 'fixed', 'a', 'b')), 'joint 0: has no name'),
    'no link': (robot(), 'no link in it; at least one expected'),
    'mimics nothing': (
        hinge('<mimic joint="x"/>'),
        "joint 'j': mimics 'x', which is no joint of it",
    ),
    'mimics no name': (hinge('<mimic multiplier="1"/>'), "joint 'j': mimic: has no joint"),
    'mimics itself': (hinge('<mimic joint="j"/>'), 'joints mimic each other in a circle: j'),
    'mimics in a circle': (
        robot(
            ABC,
            joint('p', 'revolute', 'a', 'b', '<mimic joint="q"/>'),
            joint('q', 'revolute', 'b', 'c', '<mimic joint="p"/>'),
        ),
        'joints mimic each other in a circle: p, q',
    ),
    'mimics a fixed joint': (
        robot(ABC, joint('p', 'fixed', 'a', 'b'),
              joint('q', 'revolute', 'b', 'c', '<mimic joint="p"/>')),
        "joint 'q': mimics 'p', which is fixed",
    ),
    'a factor that is no number': (
        hinge('<mimic joint="j" multiplier="twice"/>'),
        "joint 'j': mimic: multiplier: 'twice' given, a number expected",
    ),
    'an axis of no length': (hinge('<axis xyz="0 0 0"/>'), "joint 'j': axis: xyz is 0 0 0; a "),
    'an axis of NaN': (
        hinge('<axis xyz="0 nan 0"/>'),
        "joint 'j': axis: xyz: nan given, a finite number expected",
    ),
    'a place out of range': (
        hinge('<origin xyz="1e999 0 0"/>'),
        "joint 'j': origin: xyz: 1e999 given, a finite number expected",
    ),
    'a factor out of range': (
        robot(
            ABC + link('d'),
            joint('p', 'revolute', 'a', 'b'),
            joint('q', 'revolute', 'b', 'c', '<mimic joint="p" multiplier="1e200"/>'),
            joint('r', 'revolute', 'c', 'd', '<mimic joint="q" multiplier="1e200"/>'),
        ),
        "joint 'r': what it mimics gives no finite number",
    ),
    'no number': (
        hinge('<origin xyz="0x1 0 0"/>'),
        "joint 'j': origin: xyz: '0x1' given, a number expected",
    ),
    'two numbers': (
        hinge('<origin xyz="1 2"/>'),
        "joint 'j': origin: xyz: '1 2' given, three numbers expected",
    ),
    'commas': (
        hinge('<origin rpy="0,0,1"/>'),
        "joint 'j': origin: rpy: '0,0,1' given, three numbers expected",
    ),
    'a decimal comma': (
        hinge('<origin rpy="0 0 1,5"/>'),
        "joint 'j': origin: rpy: '1,5' given, a number expected",
    ),
    'an underscore': (
        hinge('<origin rpy="0 0 1_5"/>'),
        "joint 'j': origin: rpy: '1_5' given, a number expected",
    ),
    'no limits': (
        robot(AB, '<joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint>'),
        "joint 'j': revolute, but has no <limit>; lower and upper, or type continuous, expected",
    ),
    'no limits of a slider': (
        robot(AB, '<joint name="j" type="prismatic"><parent link="a"/><child link="b"/></joint>'),
        "joint 'j': prismatic, but has no <limit>; lower and upper expected",
    ),
    'limits the wrong way': (
        hinge('<limit lower="1" upper="-1"/>'),
        "joint 'j': limit: lower 1 is above upper -1",
    ),
    'an infinite limit': (
        hinge('<limit lower="-inf" upper="1"/>'),
        "joint 'j': limit: lower: -inf given, a finite number expected",
    ),
    'a macro': (
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arm side="left"/>'
        '<link name="a"/></robot>',
        'has <xacro:arm> in it; expand it: ros2 run xacro xacro FILE.xacro -o FILE.urdf',
    ),
    'an expression': (hinge('<origin xyz="0 0 ${length}"/>'), "has '0 0 ${length}' in it; expand"),
    'an argument': (robot(link('$(arg prefix)a')), "has '$(arg prefix)a' in it; expand it"),
    'a macro without its namespace': (
        '<robot><xacro:arm/></robot>',
        'not valid XML: unbound prefix: line 1, column 7; expand it: ros2 run xacro',
    ),
    'a link of a very long name': (
        robot(link('x' * 100_000), link('x' * 100_000)),
        f"link '{'x' * 96}...: given twice; names that differ expected",
    ),
    'a link of two lines': (
        robot(link('a&#10;b'), link('a&#10;b')),
        r"link 'a\nb': given twice; names that differ expected",
    ),
    'bones that are no links': (
        robot(AB, joint('j', 'fixed', 'a', 'b'), '<linkedplane_ros bones="a x"/>'),
        "no link of that name for bone 'x'; its links are a, b; bone_links: x:=LINK names another",
    ),
    'no URDF': ('<sdf version="1.6"/>', 'its root is <sdf>; <robot>, a URDF, expected'),
    'not XML': ('bones: [a, b]', 'not valid XML: syntax error: line 1, column 0; a URDF expected'),
    'cut off': (robot(AB)[:-3], 'not valid XML: unclosed token'),
    'empty': ('', 'empty; a URDF expected'),
    'blank': (' \n', 'empty; a URDF expected'),
    'entities': (
        '<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]><robot>&b;</robot>',
        "it declares a document type, 'robot'; none expected",
    ),
    'a half pair': ('<robot name="\ud800"/>', 'not valid XML'),
    'too many links': (
        robot(*(link(f'l{i}') for i in range(1001))),
        '1001 links given, at most 1000 expected',
    ),
}  # fmt: skip


@pytest.mark.parametrize('case', NO_TREES)
def test_what_is_no_tree_of_joints_is_refused_in_one_line(case: str) -> None:
    text, reason = NO_TREES[case]
    with pytest.raises(SkeletonError) as refused:
        Skeleton.from_urdf(text)
    message = str(refused.value)
    assert message.startswith(f'robot_description: {reason}')
    assert len(message.splitlines()) == 1


def test_bytes_that_are_no_text_are_refused() -> None:
    for content in (b'\x89PNG\r\n\x1a\n\0\0', b'\xff\xfe', b'<robot name="\xff"/>', b'\0' * 99):
        with pytest.raises(SkeletonError, match=r'^file: not valid XML'):
            Skeleton.from_urdf(content, 'file')
    for content in (None, 5, ['<robot/>']):
        with pytest.raises(SkeletonError, match='given, the text of a URDF expected'):
            Skeleton.from_urdf(content)  # type: ignore[arg-type]
    unknown = b'<?xml version="1.0" encoding="klingon"?><robot><link name="a"/></robot>'
    with pytest.raises(SkeletonError, match=r'^file: not valid XML'):
        Skeleton.from_urdf(unknown, 'file')


@pytest.mark.parametrize('encoding', ['utf-8', 'utf-8-sig', 'utf-16', 'latin-1'])
def test_a_urdf_is_read_in_the_encoding_that_it_declares(encoding: str) -> None:
    declared = encoding.removesuffix('-sig')
    text = f'<?xml version="1.0" encoding="{declared}"?>{robot(link("épaule"))}'
    assert Skeleton.from_urdf(text.encode(encoding)).bones == ('épaule',)
    assert Skeleton.from_urdf(text).bones == ('épaule',)


def test_numbers_are_read_as_xml_schema_writes_them() -> None:
    inside = '<origin xyz=" .5\n1.\t+1e-3 "/><axis xyz="1e-300 5e-324 1.7e308"/>'
    skeleton = Skeleton.from_urdf(robot(AB, joint('j', 'continuous', 'a', 'b', inside)))
    R, t = skeleton.pose([0.3])['b']
    assert t.tolist() == [0.5, 1.0, 0.001]
    assert abs(R[0, 0] - np.cos(0.3)) < 1e-15


def test_elements_of_other_programs_are_passed_over() -> None:
    others = (
        '<!-- no --><transmission name="t"><joint name="j"/><joint name="j"/></transmission>'
        '<gazebo><link name="a"/></gazebo><ros2_control><joint name="j" type="?"/></ros2_control>'
        '<material name="${m}"/>'
    )
    text = robot(AB, others, joint('j', 'fixed', 'a', 'b', '<mimic joint="?"/><axis xyz="0 0 0"/>'))
    assert Skeleton.from_urdf(text).bones == ('a', 'b')
    text = text.replace('<robot ', '<robot xmlns="http://www.ros.org" ')
    assert Skeleton.from_urdf(text).bones == ('a', 'b')


def test_a_deeply_nested_document_is_read_or_refused() -> None:
    depth = 300_000
    with pytest.raises(SkeletonError, match='no link in it'):
        Skeleton.from_urdf('<robot>' + '<a>' * depth + '</a>' * depth + '</robot>')


def test_text_of_more_than_16_mib_is_refused_unread() -> None:
    with pytest.raises(SkeletonError, match='larger than 16 MiB, the most that is read'):
        Skeleton.from_urdf('<' * (16 * 2**20 + 1))


def refusal(name: str | Path) -> str:
    with pytest.raises(SkeletonError) as refused:
        Skeleton.load(name)
    return str(refused.value)


def test_files_that_cannot_be_read_are_refused_in_one_line(tmp_path: Path) -> None:
    missing, folder, pipe, large = (tmp_path / f'{name}.urdf' for name in 'abcd')
    folder.mkdir()
    os.mkfifo(pipe)
    with large.open('wb') as file:
        file.truncate(16 * 2**20 + 1)
    assert refusal(missing) == f'{missing}: cannot be read: No such file or directory'
    assert refusal(folder) == f'{folder}: cannot be read: Is a directory'
    assert refusal(pipe) == f'{pipe}: cannot be read: not a regular file'
    assert refusal(large) == f'{large}: larger than 16 MiB, the most that is read'
    assert refusal('a\0b.urdf') == 'a\0b.urdf: cannot be read: embedded null byte'


def test_a_name_that_is_neither_bundled_nor_a_urdf_is_refused() -> None:
    known = 'neither a bundled skeleton (hip, shoulder_girdle) nor a path to a .urdf file'
    assert refusal('girdle') == f"skeleton: 'girdle' is {known}"
    assert refusal('arm.urdf.xacro') == (
        f"skeleton: 'arm.urdf.xacro' is {known}; "
        'expand it: ros2 run xacro xacro FILE.xacro -o FILE.urdf'
    )


def test_an_error_is_one_of_the_package() -> None:
    assert issubclass(SkeletonError, linkedplane_ros.LinkedPlaneError)


def test_the_skeleton_is_imported_when_it_is_used() -> None:
    code = 'import linkedplane_ros, sys; assert not any("skeleton" in name for name in sys.modules)'
    subprocess.run([sys.executable, '-c', code], check=True)
