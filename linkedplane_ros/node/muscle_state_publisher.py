# SPDX-License-Identifier: Apache-2.0
"""The node muscle_state_publisher: joint states in, muscle states out.

A JointState becomes three angles in `joints.joint_state`; `outputs` answers them for each muscle.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from threading import Timer
from time import perf_counter
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

from ..errors import LinkedPlaneError, describe_value, escape_controls
from ..joints.joint_state import JointMemory, OtherJoints, Rejected
from ..linked_planes.compilation import COMPILED
from ..recordings.motion import Frame
from ..skeleton.still_second import StillSecond
from . import qos
from .articulations import BY_TOPIC, Received
from .declaration import declare_parameters
from .frame_input import FrameInput
from .outputs import THROTTLE, MuscleOutputs
from .parameter_requests import refuse_odd_requests
from .parameters import NAMES, is_list
from .rehearsal import rehearse
from .robot_description import DescriptionReader
from .ros_arguments import warn_of_unknown_parameters
from .settings import Settings, refusals
from .topics import DIAGNOSTICS, JOINT_STATES, NODE_NAME

USE_SIM_TIME = 'use_sim_time'
OF_REST = ('rest', 'joint_convention', 'joint_names', 'joint_signs', 'joint_offsets')
OTHERS_ALONE = 2.0  # s: so long after the first message of other joints, ours should have come


class MuscleStatePublisher(Node):
    """Answers every accepted JointState with the state of each muscle."""

    def __init__(self, **kwargs: Any) -> None:
        """Declare parameters and topics; LinkedPlaneError for a parameter that cannot be used."""
        super().__init__(NODE_NAME, **kwargs)
        self._muscles: Sequence[MuscleOutputs] = ()
        self._peer_lines: list[str] = []
        self._awaited = ''
        # accepted, not applied
        self._candidate: tuple[Settings, list[MuscleOutputs], Received] | None = None
        self._received = Received()
        self._description = DescriptionReader(self, self._take_description)
        self._frames = FrameInput(self, self._answer_frame, self._reject_frame)
        self._simulated = self._is_time_simulated()
        with self._noticed():
            settings = declare_parameters(self)
        for text, fault in settings.left_out.items():
            self.get_logger().error(f'muscle {text} is left out: {fault}')
        self._apply(settings, self._open_outputs(settings), self._received)
        self._diagnostics = self.create_publisher(
            DiagnosticArray,
            DIAGNOSTICS.name,
            qos.profile(DIAGNOSTICS),
            event_callbacks=PublisherEventCallbacks(use_default_callbacks=False),
        )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0, self._report, clock=steady)
        refuse_odd_requests(self)
        self.add_on_set_parameters_callback(self._check_changes)
        self.add_post_set_parameters_callback(self._apply_changes)
        with qos.override_errors():
            self._input = self.create_subscription(
                JointState,
                JOINT_STATES.name,
                self._answer,
                qos.profile(JOINT_STATES),
                event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
                qos_overriding_options=qos.overridable_policies(),
            )
        self._log_settings()
        self._warn_of_convention()
        warn_of_unknown_parameters(self)

    @contextmanager
    def _noticed(self) -> Iterator[None]:
        """Log a line if the block takes long because the solver is compiled."""
        line = 'preparing the solver; the first start compiles it'
        notice = Timer(1.0, self.get_logger().info, [line])
        if COMPILED:
            notice.start()
        try:
            yield
        finally:
            notice.cancel()

    def _log_settings(self) -> None:
        settings, moved = self._settings, self._settings.articulations
        joints = f'; joints {", ".join(settings.joints.names)}, {moved.measures}'
        self.get_logger().info(
            f'{", ".join(muscle.name for muscle in self._muscles)}, '
            f'{settings.solvers[0].side} shoulder; {moved.summary}' + joints * bool(moved.measures)
        )

    def _warn_of_convention(self) -> None:
        """Log what the streams usually measure, and which bones do not move, if it matters."""
        for caution in self._settings.cautions:
            self.get_logger().warning(caution)

    def _apply(
        self, settings: Settings, muscles: Sequence[MuscleOutputs], received: Received
    ) -> None:
        """Use these settings and answer with these muscles from now on."""
        moved = settings.articulations
        if len(muscles) == len(self._muscles) == 1:  # the counts go on
            muscles[0].tally = self._muscles[0].tally
        for gone in self._muscles:
            if gone not in muscles:
                gone.close()
        if not hasattr(self, '_memory') or self._memory.joints != settings.joints:
            self._memory = JointMemory(settings.joints)
            self._has_come = False  # a message of our joints
            self._other: OtherJoints | None = None  # the newest that has not been logged
            self._first_other: float | None = None  # s, when it came
            self._others_logged = False
        if received.rest is None:
            self._still = StillSecond()
        self._received = received if moved.by_topic else replace(received, urdf=None)
        self._description.want(moved.by_topic)
        self._memory.timeout = settings.joint_timeout
        self._settings, self._muscles = settings, muscles
        logger = self.get_logger()
        moved_by = moved.moved_by or (None,) * len(muscles)
        for muscle, solver, by in zip(muscles, settings.solvers, moved_by, strict=True):
            own = logger if len(muscles) == 1 else logger.get_child(muscle.name)
            muscle.apply(settings, solver, by, own)
        self._frames.apply(settings)
        if moved.awaited and moved.awaited != self._awaited:
            logger.info(f'waiting for {moved.awaited}')
        self._awaited = moved.awaited

    def _open_outputs(self, settings: Settings) -> list[MuscleOutputs]:
        """Return the outputs of the settings' muscles, keeping those that are open by name."""
        kept = {(muscle.name, muscle.many_bones): muscle for muscle in self._muscles}
        names = [(each.muscle.name, len(each.bones) > 2) for each in settings.solvers]
        opened: dict[tuple[str, bool], MuscleOutputs] = {}
        try:
            with qos.override_errors():
                for name in names:
                    if name not in kept:
                        opened[name] = MuscleOutputs(self, *name)
        except LinkedPlaneError:
            for muscle in opened.values():
                muscle.close()
            raise
        return [kept.get(name) or opened[name] for name in names]

    def _check_changes(self, changes: list[Parameter]) -> SetParametersResult:
        """Accept a batch of parameter changes if all of it can be used."""
        names = {change.name for change in changes}
        if names.isdisjoint(NAMES):
            return SetParametersResult(successful=True)
        may_fail = () if 'muscle' in names else self._settings.left_out
        self._drop_candidate()
        try:
            with self._noticed(), refusals('parameters'):
                received = self._received
                if not names.isdisjoint(OF_REST):
                    received = replace(received, rest=None)
                settings = Settings.from_values(self._merge_values(changes), may_fail, received)
                rehearse(settings)
                self._candidate = settings, self._open_outputs(settings), received
        except LinkedPlaneError as error:
            return SetParametersResult(successful=False, reason=escape_controls(str(error)))
        return SetParametersResult(successful=True)

    def _drop_candidate(self) -> None:
        """Close what was opened for a batch that was refused after all, by another check."""
        if self._candidate is not None:
            for muscle in self._candidate[1]:
                if muscle not in self._muscles:
                    muscle.close()
        self._candidate = None

    def _apply_changes(self, changes: list[Parameter]) -> None:
        """Use accepted parameters, and log each."""
        names = {change.name for change in changes}
        if self._candidate is not None and not names.isdisjoint(NAMES):
            self._apply(*self._candidate)
            self._candidate = None
        if USE_SIM_TIME in names:
            self._simulated = self._is_time_simulated()
        for change in changes:
            if not change.name.startswith('qos_overrides.'):  # declared with a muscle's topics
                value = list(change.value) if is_list(change.value) else change.value
                self.get_logger().info(
                    f'parameter {change.name}: {describe_value(value)} from now on'
                )
        if not names.isdisjoint(('joint_convention', 'skeleton', 'rhythm', 'muscle')):
            self._warn_of_convention()

    def _is_time_simulated(self) -> bool:
        return bool(self.get_parameter(USE_SIM_TIME).value)

    def _merge_values(self, changes: list[Parameter]) -> dict[str, Any]:
        values = {name: self.get_parameter(name).value for name in NAMES}
        values.update({change.name: change.value for change in changes})
        return values

    def _answer(self, message: JointState) -> None:
        """Let each muscle answer one joint state, or log why it is rejected."""
        if self._settings.sources:  # poses in /tf move the bones
            return
        start = perf_counter()
        stamp = message.header.stamp
        if self._awaited and not self._settings.articulations.finds_rest:
            self._reject_waiting(start)
            return
        try:
            angles, speeds, warning = self._memory.take_message(
                message.name,
                message.position,
                message.velocity,
                stamp,
                self._read_clock() if self._simulated else start,
            )
        except OtherJoints as error:
            self._other = error
            self._first_other = start if self._first_other is None else self._first_other
            for muscle in self._muscles:
                muscle.pass_over(error)
            return
        except Rejected as error:
            self._has_come = True
            for muscle in self._muscles:
                muscle.reject(error, start)
            self.get_logger().warning(
                f'joint state not used: {error}', throttle_duration_sec=THROTTLE
            )
            return
        self._has_come = True
        if warning:
            self.get_logger().warning(warning, throttle_duration_sec=THROTTLE)
        if self._awaited and not self._find_rest(stamp, angles, start):
            self._reject_waiting(start)
            return
        for muscle in self._muscles:
            start = muscle.answer(stamp, angles, speeds, start)

    def _answer_frame(self, number: int, frame: Frame, start: float) -> None:
        """Let a muscle answer the poses of its bones."""
        muscle, reading = self._muscles[number], self._settings.sources[number].reading
        stamp = Time(sec=frame.stamp // 10**9, nanosec=frame.stamp % 10**9)
        if reading is None or frame.poses is None:
            muscle.answer(stamp, frame.angles, None, start)
            return
        try:
            measured = reading.read_poses(frame.poses[np.newaxis])
        except LinkedPlaneError as error:
            self._reject_frame(number, Rejected('no_angles', str(error)), start)
            return
        if self._settings.sources[number].skeleton:
            muscle.tally.take_misfit(float(measured.turn[0]), float(measured.shift[0]))
        muscle.answer(stamp, tuple(measured.values[0].tolist()), None, start, measured)

    def _reject_frame(self, number: int, error: Rejected, start: float) -> None:
        self._muscles[number].reject(error, start)
        self.get_logger().warning(f'pose not used: {error}', throttle_duration_sec=THROTTLE)

    def _reject_waiting(self, start: float) -> None:
        """Count a message that came too early; the log has said once for what the node waits."""
        for muscle in self._muscles:
            muscle.reject(Rejected('waiting', f'waiting for {self._awaited}'), start)

    def _find_rest(self, stamp: Time, angles: Sequence[float], start: float) -> bool:
        """Take a pose in; return whether the subject's rest is known, then used from now on."""
        rotation = self._settings.convention.rotation(angles)
        nanoseconds = stamp.sec * 10**9 + stamp.nanosec or int(1e9 * start)
        rest = self._still.add(nanoseconds, {'humerus': rotation})
        if rest is None:
            return False
        received = replace(self._received, rest=rest)
        values, left_out = self._merge_values([]), self._settings.left_out
        settings = Settings.from_values(values, left_out, received)
        self._apply(settings, self._muscles, received)
        self.get_logger().info(f'the arm hangs still: {settings.articulations.measures}')
        return True

    def _take_description(self, text: str) -> None:
        """Use a URDF from now on, or log why not."""
        if text == self._received.urdf:
            return
        received = replace(self._received, urdf=text)
        values, left_out = self._merge_values([]), self._settings.left_out
        try:
            with self._noticed(), refusals(BY_TOPIC):
                settings = Settings.from_values(values, left_out, received)
                rehearse(settings)
                outputs = self._open_outputs(settings)
        except LinkedPlaneError as error:
            known = self._received.urdf is not None
            kept = 'the one before stays' if known else 'still waiting for one'
            line = escape_controls(str(error))
            self.get_logger().error(f'robot description not used: {line}; {kept}')
            return
        self._drop_candidate()
        self._apply(settings, outputs, received)
        self._log_settings()

    def _read_clock(self) -> float:
        """Return the time, s, on which joints grow old: the simulated one, if time is simulated."""
        if self._simulated:
            return 1e-9 * self.get_clock().now().nanoseconds
        return perf_counter()

    def _log_others(self) -> None:
        """Log that other joints come: once beside ours, a warning where they come instead."""
        other, first = self._other, self._first_other
        if other is None or first is None:
            return
        if self._has_come and not self._others_logged:
            self._others_logged = True
            self.get_logger().info(f'joint states of other joints are passed over: {other.names}')
        elif not self._has_come and perf_counter() - first > OTHERS_ALONE:
            self.get_logger().warning(
                f'joint state not used: {other}', throttle_duration_sec=THROTTLE
            )
            self._other = None

    def _report(self) -> None:
        """Once a second: log what is odd, serve new viewers, publish the diagnostics."""
        self._log_others()
        self._frames.log_lacking()
        self._drop_candidate()
        of_input = qos.describe_incompatible_peers(self, self._input)
        of_input += self._description.describe_incompatible_peers()
        of_input += self._frames.describe_incompatible_peers()
        lines = list(of_input)
        for muscle in self._muscles:
            lines += muscle.check_peers(of_input)[len(of_input) :]
        same_name = self._describe_namesakes()
        for muscle in self._muscles:
            muscle.tally.same_name = same_name
        lines += [same_name] if same_name else []
        for line in lines:
            if line not in self._peer_lines:
                self.get_logger().warning(line)
        self._peer_lines = lines
        for muscle in self._muscles:
            muscle.republish_markers()
        ages = self._memory.find_ages(self._read_clock())
        unseen = [] if self._settings.sources else self._memory.find_unseen()
        for number, muscle in enumerate(self._muscles):
            muscle.tally.unseen = unseen
            muscle.tally.lacking = self._frames.describe_lacking(number)
        array = DiagnosticArray(status=[muscle.build_status(ages) for muscle in self._muscles])
        array.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(array)

    def _describe_namesakes(self) -> str:
        """Return a line if other nodes of the graph have this node's name; empty if none has."""
        own = self.get_name(), self.get_namespace()
        others = self.get_node_names_and_namespaces().count(own) - 1
        if others < 1:
            return ''
        name = self.get_fully_qualified_name()
        return (
            f'{others} more of the name {name} in the graph (unless killed a moment ago): '
            'parameters reach any of them; give each a name, -r __node:=NAME, or a namespace'
        )
