# SPDX-License-Identifier: Apache-2.0
"""A chain of joints, read from a URDF: where it poses a muscle's bones, and how it moves them."""
