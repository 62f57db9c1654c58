# SPDX-License-Identifier: Apache-2.0
"""What is beside the scene: controls that move an arm, plots, a table, and buttons that save."""
