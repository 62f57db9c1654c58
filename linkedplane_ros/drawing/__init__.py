# SPDX-License-Identifier: Apache-2.0
"""A state as shapes for markers and scenes, and as pictures.

`bones`, `colours` and `planes` serve all; `shapes` are the markers before they are messages;
`picture` shows a model, `plot` a processed recording.
"""
