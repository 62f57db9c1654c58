# SPDX-License-Identifier: Apache-2.0
"""Which columns of a motion table are the joints."""

from __future__ import annotations

import pytest
from motion_tables import JOINTS

from linkedplane_ros.errors import RecordingError
from linkedplane_ros.recordings.tables.columns import find_joint_columns

OPENSIM = (
    '/jointset/shoulder/plane_elv/value',
    '/jointset/shoulder/plane_elv/speed',
    '/jointset/shoulder/shoulder_elv/value',
    '/jointset/shoulder/shoulder_elv/speed',
    '/jointset/acromioclavicular/axial_rot',
    '/forceset/DELT1/activation',
)


def test_a_joint_is_the_column_of_its_name() -> None:
    columns = ('axial_rot', 'other/plane_elv', 'plane_elv', 'shoulder_elv')
    assert find_joint_columns(columns, JOINTS) == JOINTS
    assert find_joint_columns(columns, ('plane_elv',) * 2) == ('plane_elv',) * 2
    assert find_joint_columns(columns, ()) == ()


def test_a_joint_is_the_end_of_an_opensim_path() -> None:
    assert find_joint_columns(OPENSIM, JOINTS) == (OPENSIM[0], OPENSIM[2], OPENSIM[4])
    assert find_joint_columns(OPENSIM, ('shoulder/plane_elv', 'activation')) == (
        OPENSIM[0],
        OPENSIM[5],
    )
    assert find_joint_columns(('plane_elv/value',), ('plane_elv',)) == ('plane_elv/value',)


@pytest.mark.parametrize(
    'column', ['my_plane_elv', 'plane_elv_radius', 'plane_elv/speed', 'Plane_elv']
)
def test_a_name_that_is_only_like_it_is_not_chosen_but_offered(column: str) -> None:
    with pytest.raises(RecordingError) as caught:
        find_joint_columns(('x', column), ('plane_elv',))
    hint = '' if column.endswith('speed') else f' (near: {column})'
    assert str(caught.value) == f'no column for plane_elv{hint}; the file has x, {column}'


def test_what_is_near_comes_first_even_of_a_path() -> None:
    with pytest.raises(RecordingError) as caught:
        find_joint_columns(OPENSIM, ('plane_elev', 'shoulder_elv', 'axial_rotation'))
    assert str(caught.value).startswith(
        f'no column for plane_elev, axial_rotation (near: {OPENSIM[0]}, {OPENSIM[4]}'
    )


def test_of_many_columns_twelve_are_listed() -> None:
    with pytest.raises(RecordingError) as caught:
        find_joint_columns([f'c\n{i}' for i in range(20)], ('plane_elv',))
    listed = ', '.join(f'c {i}' for i in range(12))
    assert str(caught.value) == f'no column for plane_elv; the file has {listed} and 8 more'


def test_of_no_columns_nothing_is_listed() -> None:
    with pytest.raises(RecordingError, match='no column for a; the file has nothing'):
        find_joint_columns((), ('a',))


@pytest.mark.parametrize(
    'columns', [('a', 'a'), ('/left/a', '/right/a'), ('/left/a/value', '/right/a/value')]
)
def test_a_joint_that_may_be_two_columns_is_refused(columns: tuple[str, str]) -> None:
    with pytest.raises(RecordingError) as caught:
        find_joint_columns(columns, ('a',))
    assert str(caught.value) == f'2 columns for a: {columns[0]}, {columns[1]}; one expected'
