# SPDX-License-Identifier: Apache-2.0
"""A muscle at a pose: lengths, moment vectors, wrap states, and how deep bands enter bone."""
