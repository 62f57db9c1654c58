# SPDX-License-Identifier: Apache-2.0
"""One muscle of the node: from three angles to its state, published on its topics."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from posixpath import join
from time import perf_counter
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.exceptions import InvalidTopicNameException
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.node import Node

from ..drawing.shapes import RateLimiter
from ..errors import LinkedPlaneError, describe_value
from ..joints.articulation import PRISMATIC, Articulation
from ..joints.conventions import NEAR_SINGULAR, sine_of_singularity
from ..joints.joint_state import OtherJoints, Rejected
from ..linked_planes.compilation import COMPILED
from ..processing.lengthening import LengthRates
from ..skeleton.followed_girdle import FollowedGirdle
from ..skeleton.joint_limits import JointLimits
from ..skeleton.lost_plane import count_without_plane
from ..skeleton.measured import MeasuredBones
from ..skeleton.skeleton import Skeleton
from ..solver.linked_plane_solver import LinkedPlaneSolver
from ..solver.moment_bounds import moment_arm_bounds
from ..solver.states import Answer, MuscleState
from ..types import Floats, JointValues
from . import qos
from .diagnostics import STALE_AFTER, Tally, build_status
from .markers import MuscleMarkers
from .messages import Answers, message_class
from .range_count import OddCounter
from .settings import Settings
from .topics import BONE_OUTPUTS, NODE_NAME, OUTPUTS

THROTTLE = 5.0  # s between log lines on rejected messages
LONGEST_TOPIC = 247  # characters, with the namespace: the middleware's longest name
DEGREES_AT_LEAST = 50  # messages: fewer are faults of some messages, not of their unit


class MuscleOutputs:
    """Publishes the state of one muscle for the angles that the node has received."""

    def __init__(self, node: Node, name: str, many_bones: bool = False) -> None:
        """Create the publishers, named after the muscle; those of many bones, too.

        LinkedPlaneError for a name that topics cannot have, RuntimeError for a wrong override.
        """
        self.name, self.many_bones = name, many_bones
        outputs = (*OUTPUTS, *BONE_OUTPUTS) if many_bones else OUTPUTS
        self.tally = Tally()
        self.topics: dict[str, Any] = {}
        self._node = node
        self._served = 0  # viewers of the newest markers
        self._cleared = False
        try:
            for topic in outputs:
                self.topics[topic.name] = node.create_publisher(
                    message_class(topic.type),
                    f'{name}/{topic.name}',
                    qos.profile(topic),
                    event_callbacks=PublisherEventCallbacks(use_default_callbacks=False),
                    qos_overriding_options=qos.overridable_policies(),
                )
        except InvalidTopicNameException:
            self.close()
            full = join(node.get_namespace(), name, topic.name)
            raise LinkedPlaneError(
                f'parameter muscle: {describe_value(name)} is no name for topics: {topic.name} '
                f'would have {len(full)} characters with it, at most {LONGEST_TOPIC} of letters, '
                'digits, _ and / expected'
            ) from None
        except Exception:
            self.close()
            raise
        self._on_demand = {
            topic.name
            for topic in outputs
            if topic.on_demand and not qos.is_latched(self.topics[topic.name])
        }

    def apply(
        self,
        settings: Settings,
        solver: LinkedPlaneSolver,
        moved_by: Articulation | None,
        logger: RcutilsLogger,
    ) -> None:
        """Use these settings from now on; what cannot be answered is logged.

        `moved_by` is what moves the muscle's bones; None while that has still to come.
        """
        if not settings.markers_enabled:
            self._clear_markers()
        muscle = solver.muscle
        self._settings, self._solver, self._logger = settings, solver, logger
        moved = settings.articulations
        self._moved_by, self._still = moved_by, (0.0,) * len(moved.coordinates)
        self._rates = LengthRates()
        self._cleared = False
        self.tally.last_state = None  # that of other settings
        self._markers = MuscleMarkers(
            muscle, settings.frame_id, settings.markers_points, settings.markers_details
        )
        self._limiter = RateLimiter(settings.markers_rate)
        self._outside = OddCounter(muscle.count_outside_range)
        self._odd_values = _count_odd_values(moved_by)
        self._bounds = moment_arm_bounds(muscle)
        self._least_square = float(self._bounds.min()) ** 2
        self.tally.oldest = settings.joint_timeout or STALE_AFTER
        self.tally.awaited = moved.awaited
        self._answers = Answers(
            muscle.band_names, moved.coordinates, settings.frame_id, solver.bones[1:]
        )

    def close(self) -> None:
        """Destroy the publishers; no viewer keeps the muscle."""
        self._clear_markers()
        for publisher in self.topics.values():
            self._node.destroy_publisher(publisher)

    def _clear_markers(self) -> None:
        if self._cleared:
            self.topics['markers'].publish(self._markers.clear(self._last_stamp))

    def reject(self, error: Rejected, start: float) -> None:
        """Count a joint state that the node rejected; it came at `start`, s."""
        tally = self.tally
        tally.received += 1
        tally.last_arrival = start
        self._count_rejection(error)

    def pass_over(self, error: OtherJoints) -> None:
        """Count a joint state of other joints alone."""
        self.tally.received += 1
        self.tally.others += 1
        self.tally.last_other = str(error)

    def _count_rejection(self, error: Rejected) -> None:
        tally = self.tally
        tally.rejected[error.reason] += 1
        tally.last_rejection = str(error)
        degrees = tally.rejected['degrees']
        if degrees >= DEGREES_AT_LEAST and degrees > tally.answered:
            self._logger.warning(
                f'joint states look like degrees throughout: {degrees} rejected, {tally.answered} '
                'answered; radians expected (REP 103)',
                once=True,
            )

    def answer(
        self,
        stamp: Time,
        angles: JointValues,
        speeds: JointValues | None,
        start: float,
        measured: MeasuredBones | None = None,
    ) -> float:
        """Publish the state at given values, or log why there is none.

        Parameters
        ----------
        stamp
            The input's.
        angles
            Of the coordinates, rad or m.
        speeds
            Their speeds, rad/s or m/s; None if the input has no velocities.
        start
            When the work on this input began, s, on the clock of perf_counter.
        measured
            Where the bones are, if that was measured; else the values say it.

        Returns
        -------
        float
            When it was done, on the same clock.

        """
        tally = self.tally
        tally.received += 1
        tally.last_arrival = start
        try:
            answer, messages = self._solve(stamp, angles, speeds, start, measured)
        except Rejected as error:
            self._count_rejection(error)
            what = 'joint state' if measured is None else 'pose'
            self._logger.warning(f'{what} not used: {error}', throttle_duration_sec=THROTTLE)
            return perf_counter()
        topics, state = self.topics, answer.state
        for name, message in messages.items():
            if self._is_wanted(name):
                topics[name].publish(message)
        if self.many_bones and self._is_wanted('wrenches'):
            topics['wrenches'].publish(self._answers.update_wrenches(state))
        if self._is_wanted('markers') and self._limiter.allows(
            stamp.sec + 1e-9 * stamp.nanosec, start
        ):
            self._publish_markers(state, stamp)
        tally.answered += 1
        self._outside.add(state.rotation)
        for counter in self._odd_values.values():
            counter.add(np.array(angles))
        if answer.axes is not None:
            tally.near_singular += sine_of_singularity(answer.axes) < NEAR_SINGULAR
        tally.last_state, self._last_stamp = state, stamp
        end = perf_counter()
        tally.callback_times.append(end - start)
        return end

    def _solve(
        self,
        stamp: Time,
        angles: JointValues,
        speeds: JointValues | None,
        start: float,
        measured: MeasuredBones | None,
    ) -> tuple[Answer, Mapping[str, Any]]:
        """Return the answer and the message of each topic; Rejected if it cannot be published."""
        try:
            answer = self._solver.answer(measured or self._moved_by, angles, speeds or self._still)
        except LinkedPlaneError as error:
            raise Rejected('no_plane', str(error)) from None
        self.tally.solve_times.append(perf_counter() - start)
        lengthening = None if speeds is None else answer.lengthening
        if measured is not None:
            lengthening = self._differentiate(stamp, answer.state)
        messages = self._answers.update(stamp, answer.state, answer.moment_arms, lengthening)
        vectors = answer.state.moment_vectors
        lever = float(np.vdot(vectors, vectors))  # m^2; while it is small, none is beyond
        if not math.isfinite(lever + self._answers.add_up()):
            raise Rejected(
                'answer_not_finite',
                f'the state of {self.name} at {self._describe_values(angles)} is not finite',
            )
        if lever > self._least_square:
            self.tally.beyond += bool((np.linalg.norm(vectors, axis=1) > self._bounds).any())
        return answer, messages

    def _describe_values(self, values: JointValues) -> str:
        """Return values of the coordinates as text, angles in deg."""
        kinds = self._settings.articulations.kinds
        if PRISMATIC not in kinds:
            return ', '.join(f'{math.degrees(value):.6g}' for value in values) + ' deg'
        return ', '.join(
            f'{value:.6g} m' if kind == PRISMATIC else f'{math.degrees(value):.6g} deg'
            for value, kind in zip(values, kinds, strict=True)
        )

    def _differentiate(self, stamp: Time, state: MuscleState) -> Floats | None:
        """Return how fast bands have grown since the pose before; None if there is none."""
        stamps = np.array([stamp.sec * 10**9 + stamp.nanosec], dtype=np.int64)
        [rates] = self._rates.take(stamps, state.lengths[np.newaxis])
        return rates if np.isfinite(rates).all() else None

    def _is_wanted(self, topic: str) -> bool:
        """Return whether somebody may read a topic; a latched one is kept for those to come."""
        return topic not in self._on_demand or bool(self.topics[topic].get_subscription_count())

    def _publish_markers(self, state: MuscleState, stamp: Time) -> None:
        """Publish the markers of a state; before the first, remove any older ones."""
        if not self._settings.markers_enabled:
            return
        if not self._cleared:
            self.topics['markers'].publish(self._markers.clear(stamp))
            self._cleared = True
        self.topics['markers'].publish(self._markers.update(state, stamp))
        self._served = self.topics['markers'].get_subscription_count()

    def republish_markers(self) -> None:
        """Publish the newest state's markers for new viewers while no input comes (a pause)."""
        viewers = self.topics['markers'].get_subscription_count()
        self._served = min(self._served, viewers)
        state, arrival = self.tally.last_state, self.tally.last_arrival
        if viewers > self._served and state and arrival and perf_counter() - arrival > 0.5:
            self._publish_markers(state, self._last_stamp)

    def check_peers(self, of_input: Sequence[str]) -> list[str]:
        """Return a line for each incompatible peer, those of the input first."""
        own = [
            line
            for publisher in self.topics.values()
            for line in qos.describe_incompatible_peers(self._node, publisher)
        ]
        self.tally.incompatible_peers = [*of_input, *own]
        return self.tally.incompatible_peers

    def build_status(self, ages: Mapping[str, float]) -> DiagnosticStatus:
        """Return the status of this muscle for the diagnostics; `ages` of the joints, s."""
        self.tally.ages = ages
        self.tally.outside += self._outside.take_count()
        for name, counter in self._odd_values.items():
            setattr(self.tally, name, getattr(self.tally, name) + counter.take_count())
        settings, side = self._settings, self._solver.side
        facts = {
            'muscle': self.name,
            'scale': settings.scale,
            'side': side,
            **settings.articulations.facts,
            **({} if settings.sources else {'joints': ', '.join(settings.joints.names)}),
            'compiled': 'yes' if COMPILED else 'no',
        }
        return build_status(
            self.tally,
            status_name(self._node, self.name),
            f'{self.name}, {side}',
            perf_counter(),
            facts,
        )


def _count_odd_values(moved_by: Articulation | None) -> dict[str, OddCounter]:
    """Return what counts odd values of coordinates, by the count of the tally."""
    if isinstance(moved_by, FollowedGirdle):
        return {'without_plane': OddCounter(partial(count_without_plane, moved_by))}
    if isinstance(moved_by, Skeleton):
        return {'beyond_limits': OddCounter(JointLimits.from_skeleton(moved_by).count_beyond)}
    return {}


def status_name(node: Node, muscle: str) -> str:
    """Return the name of a muscle's status; where the node is renamed, it says what it is.

    By that name, config/diagnostic_aggregator.yaml groups all nodes.
    """
    name = f'{node.get_fully_qualified_name()[1:]}: {muscle}'
    return name if node.get_name() == NODE_NAME else f'{name} ({NODE_NAME})'
