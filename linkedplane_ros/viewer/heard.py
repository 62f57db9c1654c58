# SPDX-License-Identifier: Apache-2.0
"""The values of all joints of an arm, also of those that its muscle does not need."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np
from sensor_msgs.msg import JointState

from ..joints.joint_state import JointMap, JointMemory, Rejected
from ..types import Floats


class HeardJoints:
    """The coordinates by the joint states so far.

    Those that the muscle needs are read as its node reads them. Each of the others, which move the
    ground under it, is read by itself, and is 0 until it has come: no node waits for it.
    """

    def __init__(self, joints: JointMap) -> None:
        """Read these joints."""
        self.joints = joints
        self._needed = JointMemory(joints)
        self._others = {
            i: JointMemory(
                replace(
                    joints,
                    names=(name,),
                    signs=(joints.signs[i],),
                    offsets=(joints.offsets[i],),
                    kinds=joints.kinds[i : i + 1],
                    idle=frozenset(),
                )
            )
            for i, name in enumerate(joints.names)
            if name in joints.idle
        }
        self._angles: Floats | None = None
        self._ground = dict.fromkeys(self._others, 0.0)

    def take_message(self, message: JointState) -> Floats | None:
        """Take one message in; return the coordinates (d,), rad or m, as they are then.

        None before all those that are needed have come. What cannot be used of a message changes
        nothing.
        """
        with suppress(Rejected):
            angles, _, _ = self._needed.take_message(message.name, message.position, ())
            self._angles = np.array(angles)
        for i, memory in self._others.items():
            with suppress(Rejected):
                (self._ground[i],), _, _ = memory.take_message(message.name, message.position, ())
        if self._angles is None:
            return None
        values = self._angles.copy()
        for i, value in self._ground.items():
            values[i] = value
        return values
