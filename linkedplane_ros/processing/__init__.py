# SPDX-License-Identifier: Apache-2.0
"""Recordings written again with the muscle's state beside the motion.

The way of the data: `inputs` finds the recordings, `options` says what is done to them, `task`
processes one and `workers` many; `outputs` and `bag_output` write, the latter with messages from
`cdr` and `cdr_markers`; `reading` reads an output again. `topics` are what the node publishes, too.
"""
