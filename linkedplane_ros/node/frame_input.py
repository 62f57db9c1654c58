# SPDX-License-Identifier: Apache-2.0
"""Poses of bones from /tf, live: read by the same code as those of recordings.

A stamp is answered once: as soon as all frames that move the bones have it, or else when a later
one comes, with the newest of each frame (`joint_timeout` says how old it may be).
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.subscription import Subscription

from ..joints.joint_state import Rejected
from ..processing.motion_source import MotionSource
from ..recordings.motion import Frame, Place
from ..recordings.poses import PoseFrameReader
from . import qos
from .articulated_frames import tf_message_class
from .outputs import THROTTLE
from .settings import Settings
from .topics import TF, TF_STATIC

TakeFrame = Callable[[int, Frame, float], None]
TakeRefusal = Callable[[int, Rejected, float], None]


class FrameInput:
    """Reads the frames of each muscle's bones while the parameter `input` asks for it.

    Parameters
    ----------
    node
        The one that subscribes.
    answer
        Called with a muscle's number, its frame and when the work on it began, s.
    reject
        Called with a muscle's number, why there is no frame, and the same.
    """

    def __init__(self, node: Node, answer: TakeFrame, reject: TakeRefusal) -> None:
        self._node, self._answer, self._reject = node, answer, reject
        self._subscriptions: list[Subscription] = []
        self._readers: dict[str, PoseFrameReader] = {}
        self._order: list[PoseFrameReader] = []

    def apply(self, settings: Settings) -> None:
        """Read what the settings say from now on; frames that are read already stay known."""
        kept, self._readers = self._readers, {}
        for solver, source in zip(settings.solvers, settings.sources, strict=False):
            key = describe_source(source, solver.side, solver.muscle.name)
            self._readers[key] = kept.get(key) or make_reader(source, settings, solver.side)
        self._order = list(self._readers.values())
        for reader in self._order:
            reader.timeout = settings.joint_timeout
        if self._order and not self._subscriptions:
            self._subscribe()
        elif not self._order:
            for subscription in self._subscriptions:
                self._node.destroy_subscription(subscription)
            self._subscriptions = []

    def _subscribe(self) -> None:
        with qos.override_errors():
            for topic in (TF_STATIC, TF):
                self._subscriptions.append(
                    self._node.create_subscription(
                        tf_message_class(),
                        topic.name,
                        lambda message, name=topic.name: self.take(message, name),
                        qos.profile(topic),
                        event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
                        qos_overriding_options=qos.overridable_policies(),
                    )
                )

    def take(self, message: Any, topic: str = TF.name) -> None:
        """Take in a message of /tf or /tf_static: answer or reject what it completes."""
        for number, reader in enumerate(list(self._order)):
            start = perf_counter()
            for frame in reader.read_frames(message, topic, Place(0, int(1e9 * start))):
                if isinstance(frame, Frame):
                    self._answer(number, frame, start)
                else:
                    self._reject(number, Rejected(frame.reason, frame.text), start)
        for reader in self._order:
            for note in reader.notes:
                self._node.get_logger().warning(note)
            reader.notes.clear()

    def describe_lacking(self, number: int) -> str:
        """Return why a muscle's bones do not hang together; empty if they do, or are not asked."""
        if number >= len(self._order):
            return ''
        lacking = self._order[number].find_lacking()
        return '' if lacking is None else str(lacking)

    def log_lacking(self) -> None:
        """Log why frames that come move no bones, if they do not."""
        for reader in self._order:
            lacking = reader.find_lacking()
            if lacking is not None and reader.tree.names:
                self._node.get_logger().warning(
                    f'no pose of the bones: {lacking}', throttle_duration_sec=THROTTLE
                )

    def describe_incompatible_peers(self) -> list[str]:
        """Return a line for each publisher whose quality of service does not fit."""
        return [
            line
            for subscription in self._subscriptions
            for line in qos.describe_incompatible_peers(self._node, subscription)
        ]


def make_reader(source: MotionSource, settings: Settings, side: str) -> PoseFrameReader:
    """Return what reads the frames of a muscle's bones, prompt."""
    assert source.frames is not None
    return PoseFrameReader(source.frames, settings.convention, side, prompt=True)


def describe_source(source: MotionSource, side: str, muscle: str) -> str:
    """Return what a reader depends on; one of the same description goes on."""
    assert source.frames is not None
    convention = ', '.join(source.coordinates)
    return f'{muscle} {side} {convention} {dict(source.frames.names)} {dict(source.frames.facts)}'
