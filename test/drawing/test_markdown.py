# SPDX-License-Identifier: Apache-2.0
"""Tables in Markdown: one writer for reports and for the documentation."""

from __future__ import annotations

from linkedplane_ros.drawing.markdown import markdown_table


def test_a_table_has_its_columns_aligned_and_its_bars_escaped() -> None:
    text = markdown_table(('band', 'length, mm', ''), [('a|b', '1.2', ''), ('', '', '')], 'lrl')
    assert text.splitlines() == [
        '| band | length, mm | |',
        '| --- | ---: | --- |',
        '| a\\|b | 1.2 | |',
        '| | | |',
    ]


def test_columns_stand_to_the_left_where_nothing_else_is_said() -> None:
    assert markdown_table(('a', 'b'), []) == '| a | b |\n| --- | --- |'
