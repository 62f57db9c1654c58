"""The node's qualities of service, and what to do where a peer asks for others."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rcl_interfaces.msg import SetParametersResult
from rclpy._rclpy_pybind11 import RCLError
from rclpy.duration import Infinite
from rclpy.exceptions import InvalidParameterTypeException
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

from .topics import Topic

BEST_EFFORT, RELIABLE = ReliabilityPolicy.BEST_EFFORT, ReliabilityPolicy.RELIABLE
MOST = 2**31 - 1  # the middleware's longest queue
VOLATILE, LATCHED = DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL


def profile(topic: Topic) -> QoSProfile:
    """Return the quality of service of a topic of the node."""
    return QoSProfile(depth=topic.depth, reliability=ReliabilityPolicy[topic.reliability.upper()])


def overridable() -> QoSOverridingOptions:
    """Return the policies that a user may override by parameters, `qos_overrides.<topic>...`."""
    return QoSOverridingOptions(
        (
            QoSPolicyKind.HISTORY,
            QoSPolicyKind.DEPTH,
            QoSPolicyKind.RELIABILITY,
            QoSPolicyKind.DURABILITY,
        ),
        callback=lambda profile: SetParametersResult(
            successful=1 <= profile.depth <= MOST,
            reason=f'depth {profile.depth}, 1 or more expected',
        ),
    )


@contextmanager
def overrides_in_one_line() -> Iterator[None]:
    """Turn what rclpy raises for a wrong override into a ValueError that tells what is right."""
    try:
        yield
    except RCLError:
        raise
    except (InvalidQosOverridesError, InvalidParameterTypeException) as error:
        raise ValueError(str(error)) from None
    except RuntimeError as error:
        raise ValueError(
            f'{error}; history: keep_last or keep_all; reliability: reliable or best_effort; '
            'durability: volatile or transient_local'
        ) from None


def misfits(node: Node, end: Publisher | Subscription) -> list[str]:
    """Return a line for each peer of one of a node's ends whose quality of service does not fit.

    To be asked now and then: an event of the middleware names no peer, and each that is listened
    for makes every wait of the executor longer.
    """
    topic = end.topic_name
    if isinstance(end, Publisher):
        strangers = node.count_subscribers(topic) - end.get_subscription_count()
    else:
        strangers = node.count_publishers(topic) - end.get_publisher_count()
    if strangers <= 0:
        return []
    own = QoSProfile(  # with what is left open as the graph tells it of the peers
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
        f'{line.format(peer=peer.node_name, topic=topic)}; {cure(end, *pair)}'
        for peer, pair in zip(peers, pairs, strict=True)
        if qos_check_compatible(*pair)[0] == QoSCompatibility.ERROR
    ]


def cure(end: Publisher | Subscription, offered: QoSProfile, wanted: QoSProfile) -> str:
    """Return what makes one of our ends fit its peer."""
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
    return f'start this node with {" ".join(overrides)}' if overrides else 'change its profile'
