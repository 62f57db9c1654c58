# SPDX-License-Identifier: Apache-2.0
"""The URDF from the topic of robot descriptions, while a parameter asks for it."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.subscription import Subscription
from std_msgs.msg import String

from . import qos
from .topics import ROBOT_DESCRIPTION


class DescriptionReader:
    """Subscribes the topic while it is wanted.

    Parameters
    ----------
    node
        The one that subscribes.
    take
        Called with the text of each message.
    """

    def __init__(self, node: Node, take: Callable[[str], None]) -> None:
        self._node, self._take = node, take
        self._subscription: Subscription | None = None

    def want(self, wanted: bool) -> None:
        """Subscribe, or end that."""
        if wanted and self._subscription is None:
            with qos.override_errors():
                self._subscription = self._node.create_subscription(
                    String,
                    ROBOT_DESCRIPTION.name,
                    lambda message: self._take(message.data),
                    qos.profile(ROBOT_DESCRIPTION),
                    event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
                    qos_overriding_options=qos.overridable_policies(),
                )
        elif not wanted and self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def describe_incompatible_peers(self) -> list[str]:
        """Return a line for each publisher whose quality of service does not fit."""
        if self._subscription is None:
            return []
        return qos.describe_incompatible_peers(self._node, self._subscription)
