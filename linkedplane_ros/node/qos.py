# SPDX-License-Identifier: Apache-2.0
"""The quality of service of the node's topics, overrides of it, and peers that do not fit."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rcl_interfaces.msg import SetParametersResult
from rclpy._rclpy_pybind11 import RCLError
from rclpy.duration import Infinite
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import (
    DurabilityPolicy,
    LivelinessPolicy,
    QoSCompatibility,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)
from rclpy.qos_overriding_options import InvalidQosOverridesError, QoSOverridingOptions
from rclpy.subscription import Subscription

from ..errors import ArgumentError
from .ros_arguments import describe_parameter_fault
from .topics import Topic

BEST_EFFORT, RELIABLE = ReliabilityPolicy.BEST_EFFORT, ReliabilityPolicy.RELIABLE
DEEPEST = 2**31 - 1  # messages: the middleware's longest queue
VOLATILE, LATCHED = DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL


def profile(topic: Topic) -> QoSProfile:
    """Return the quality of service of a topic of the node."""
    return QoSProfile(
        depth=topic.depth,
        reliability=ReliabilityPolicy[topic.reliability.upper()],
        durability=LATCHED if topic.latched else VOLATILE,
    )


def overridable_policies() -> QoSOverridingOptions:
    """Return the policies that a user may override by parameters, `qos_overrides.<topic>...`."""
    return QoSOverridingOptions(
        (
            QoSPolicyKind.HISTORY,
            QoSPolicyKind.DEPTH,
            QoSPolicyKind.RELIABILITY,
            QoSPolicyKind.DURABILITY,
        ),
        callback=lambda profile: SetParametersResult(
            successful=1 <= profile.depth <= DEEPEST,
            reason=f'depth {profile.depth}, 1 or more expected',
        ),
    )


def is_latched(publisher: Publisher) -> bool:
    """Return whether a publisher's messages are kept for subscribers that come later."""
    return bool(publisher.qos_profile.durability == LATCHED)


@contextmanager
def override_errors() -> Iterator[None]:
    """Turn what rclpy raises for a wrong override into an ArgumentError of one line."""
    try:
        yield
    except RCLError:
        raise
    except ParameterException as error:
        raise ArgumentError(describe_parameter_fault(error)) from None
    except InvalidQosOverridesError as error:
        raise ArgumentError(str(error)) from None
    except RuntimeError as error:
        raise ArgumentError(
            f'{error}; history: keep_last or keep_all; reliability: reliable or best_effort; '
            'durability: volatile or transient_local'
        ) from None


def describe_incompatible_peers(node: Node, end: Publisher | Subscription) -> list[str]:
    """Return a line for each peer of a publisher or subscription that gets or gives no messages.

    Called once a second: the middleware's own events do not name the peer, and each of them makes
    every wait of the executor longer.
    """
    topic = end.topic_name
    if isinstance(end, Publisher):
        unmatched = node.count_subscribers(topic) - end.get_subscription_count()
    else:
        unmatched = node.count_publishers(topic) - end.get_publisher_count()
    if unmatched <= 0:
        return []
    own = QoSProfile(  # what is left open as in the graph's data on peers
        depth=1,
        reliability=end.qos_profile.reliability,
        durability=end.qos_profile.durability,
        deadline=Infinite,
        liveliness=LivelinessPolicy.AUTOMATIC,
        liveliness_lease_duration=Infinite,
    )
    if isinstance(end, Publisher):
        peers = node.get_subscriptions_info_by_topic(topic)
        pairs = [(own, peer.qos_profile) for peer in peers]
        line = '{peer} receives nothing: on {topic} it asks for more than is offered'
    else:
        peers = node.get_publishers_info_by_topic(topic)
        pairs = [(peer.qos_profile, own) for peer in peers]
        line = 'nothing comes from {peer}: on {topic} it offers less than is asked for'
    return [
        f'{line.format(peer=peer.node_name, topic=topic)}; {suggest_override(end, *pair)}'
        for peer, pair in zip(peers, pairs, strict=True)
        if qos_check_compatible(*pair)[0] == QoSCompatibility.ERROR
    ]


def suggest_override(end: Publisher | Subscription, offered: QoSProfile, wanted: QoSProfile) -> str:
    """Return how to make a publisher or subscription of this node fit its peer."""
    offers = isinstance(end, Publisher)
    kind = 'publisher' if offers else 'subscription'
    values = {
        'reliability': (BEST_EFFORT, RELIABLE, 'reliable' if offers else 'best_effort'),
        'durability': (VOLATILE, LATCHED, 'transient_local' if offers else 'volatile'),
    }
    overrides = [
        f'-p qos_overrides.{end.topic_name}.{kind}.{policy}:={value}'
        for policy, (less, more, value) in values.items()
        if getattr(offered, policy) == less and getattr(wanted, policy) == more
    ]
    if not overrides:
        return 'change its quality of service'
    return f'start this node with {" ".join(overrides)}'
