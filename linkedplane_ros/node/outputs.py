"""One muscle of the node: its solver, its topics, its markers and its counts."""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.node import Node

from ..drawing.shapes import Pace
from ..joints.conventions import NEAR_SINGULAR, sine_of_singularity
from ..joints.joint_state import Rejected
from ..linked_planes.compiled import COMPILED
from ..solver.linked_plane_solver import LinkedPlaneSolver, MuscleState
from ..types import Triple
from . import qos
from .diagnostics import Tally, status
from .markers import MuscleMarkers
from .messages import Answers, message_class
from .settings import STILL, Settings
from .topics import OUTPUTS

THROTTLE = 5.0  # s between lines on rejected messages


class MuscleOutputs:
    """Answers the angles that the node has taken in on the topics of one muscle."""

    def __init__(self, node: Node, name: str) -> None:
        """Make the publishers, named after the muscle; RuntimeError for a wrong override."""
        self.name = name
        self.tally = Tally()
        self.topics: dict[str, Any] = {}
        self._node = node
        self._viewers = 0
        self._cleared = False
        try:
            for topic in OUTPUTS:
                self.topics[topic.name] = node.create_publisher(
                    message_class(topic.type),
                    f'{name}/{topic.name}',
                    qos.profile(topic),
                    event_callbacks=PublisherEventCallbacks(use_default_callbacks=False),
                    qos_overriding_options=qos.overridable(),
                )
        except RuntimeError:
            self.close()
            raise

    def apply(self, settings: Settings, solver: LinkedPlaneSolver, logger: RcutilsLogger) -> None:
        """Work with these settings from now on; what cannot be answered goes to the logger."""
        if not settings.markers_enabled:
            self._leave_nothing_behind()
        muscle = solver.muscle
        self._settings, self._solver, self._logger = settings, solver, logger
        self._convention = settings.convention
        self._cleared = False
        self.tally.last_state = None  # that of other settings
        self._markers = MuscleMarkers(
            muscle, settings.frame_id, settings.markers_points, settings.markers_details
        )
        self._pace = Pace(settings.markers_rate)
        self._answers = Answers(
            muscle.band_names, settings.convention.coordinates, settings.frame_id
        )

    def close(self) -> None:
        """Leave the topics, and no muscle in a viewer."""
        self._leave_nothing_behind()
        for publisher in self.topics.values():
            self._node.destroy_publisher(publisher)

    def _leave_nothing_behind(self) -> None:
        if self._cleared:
            self.topics['markers'].publish(self._markers.clear(self._last_stamp))

    def reject(self, error: Rejected, start: float) -> None:
        """Count a joint state that the node could not take in; it came at `start`, s."""
        tally = self.tally
        tally.received += 1
        tally.last_arrival = start
        self._count(error)

    def _count(self, error: Rejected) -> None:
        self.tally.rejected[error.reason] += 1
        self.tally.last_line = str(error)

    def answer(self, stamp: Time, angles: Triple, speeds: Triple | None, start: float) -> float:
        """Answer angles, rad, and speeds, rad/s, or say why not; return when that was done.

        `start` is when it began; both in s, on the clock of perf_counter.
        """
        tally = self.tally
        tally.received += 1
        tally.last_arrival = start
        try:
            state, arms, lengthening, axes = self._solver.answer(
                self._convention, angles, speeds or STILL
            )
        except ValueError as error:
            self._count(Rejected('no_plane', str(error)))
            self._logger.warning(f'joint state not used: {error}', throttle_duration_sec=THROTTLE)
            return perf_counter()
        tally.solve_times.append(perf_counter() - start)
        topics = self.topics
        for name, answer in self._answers.at(
            stamp, state, arms, None if speeds is None else lengthening
        ).items():
            topics[name].publish(answer)
        if topics['markers'].get_subscription_count() and self._pace.due(
            stamp.sec + 1e-9 * stamp.nanosec, start
        ):
            self._show(state, stamp)
        tally.answered += 1
        tally.near_singular += sine_of_singularity(axes) < NEAR_SINGULAR
        tally.last_state, self._last_stamp = state, stamp
        end = perf_counter()
        tally.callback_times.append(end - start)
        return end

    def _show(self, state: MuscleState, stamp: Time) -> None:
        """Publish the markers of a state; before the first, remove any that were there."""
        if not self._settings.markers_enabled:
            return
        if not self._cleared:
            self.topics['markers'].publish(self._markers.clear(stamp))
            self._cleared = True
        self.topics['markers'].publish(self._markers.at(state, stamp))

    def show_again(self) -> None:
        """Show the newest state to new viewers if no input is coming (a paused recording)."""
        viewers, before = self.topics['markers'].get_subscription_count(), self._viewers
        self._viewers = viewers
        state, arrival = self.tally.last_state, self.tally.last_arrival
        if viewers > before and state and arrival and perf_counter() - arrival > 0.5:
            self._show(state, self._last_stamp)

    def look_at_peers(self, misfits: Sequence[str]) -> list[str]:
        """Return a line for each peer that does not fit, those of the input first."""
        own = [line for end in self.topics.values() for line in qos.misfits(self._node, end)]
        self.tally.misfits = [*misfits, *own]
        return self.tally.misfits

    def status(self) -> DiagnosticStatus:
        """Return what the diagnostics tell of this muscle."""
        settings, side = self._settings, self._solver.side
        facts = {
            'muscle': self.name,
            'scale': settings.scale,
            'side': side,
            'joint convention': settings.convention.name,
            'rotation': settings.convention.formula,
            'joints': ', '.join(settings.joints.names),
            'compiled': 'yes' if COMPILED else 'no',
        }
        return status(
            self.tally,
            f'{self._node.get_fully_qualified_name()[1:]}: {self.name}',
            f'{self.name}, {side}',
            perf_counter(),
            facts,
        )
