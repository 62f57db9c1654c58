# SPDX-License-Identifier: Apache-2.0
"""A broad muscle: its file, its definition, the model in m and rad, its size on a subject."""
