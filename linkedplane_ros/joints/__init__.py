# SPDX-License-Identifier: Apache-2.0
"""From a joint state to the pose: the joint conventions, and what is accepted of a message."""
