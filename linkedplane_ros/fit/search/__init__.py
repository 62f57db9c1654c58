# SPDX-License-Identifier: Apache-2.0
"""The search for the least criterion: a swarm, its polish, and the state of both on disk."""
