# SPDX-License-Identifier: Apache-2.0
"""The ROS node: topics, parameters, diagnostics, messages.

The way of the data: parameters -> settings; a JointState -> angles (`joints.joint_state`) -> a
muscle's state (`outputs`) -> arrays (`messages`) and markers (`markers`) -> topics (`topics`).
"""
