# SPDX-License-Identifier: Apache-2.0
"""The study's figures: the muscle at its poses, and charts."""
