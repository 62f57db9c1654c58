# SPDX-License-Identifier: Apache-2.0
"""The muscle in a browser: the node muscle_viewer. It shows what is published.

Only the arm at rest, which is seen before anything is published, is solved here.

The way of the data: topics (`node`) -> newest state (`newest`) -> markers, geometry and scene
(`scene`), and plots and table beside it (`panels`), drawn with the library viser once a frame
(`app`); from sliders and buttons (`panels`) back to joint states (`node`).
"""
