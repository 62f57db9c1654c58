# SPDX-License-Identifier: Apache-2.0
"""The node muscle_state_publisher: joint states in, muscle states out.

A JointState becomes three angles in `joints.joint_state`; `outputs` answers them for each muscle.
"""

from __future__ import annotations

from collections.abc import Sequence
from threading import Timer
from time import perf_counter
from typing import Any

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
from . import qos
from .declaration import declare_parameters
from .outputs import THROTTLE, MuscleOutputs
from .parameter_requests import refuse_odd_requests
from .parameters import NAMES, is_list
from .rehearsal import rehearse
from .ros_arguments import warn_of_unknown_parameters
from .settings import Settings, refusals
from .topics import DIAGNOSTICS, JOINT_STATES, NODE_NAME

USE_SIM_TIME = 'use_sim_time'
OTHERS_ALONE = 2.0  # s: so long after the first message of other joints, ours should have come


class MuscleStatePublisher(Node):
    """Answers every accepted JointState with the state of each muscle."""

    def __init__(self, **kwargs: Any) -> None:
        """Declare parameters and topics; LinkedPlaneError for a parameter that cannot be used."""
        super().__init__(NODE_NAME, **kwargs)
        self._muscles: Sequence[MuscleOutputs] = ()
        self._peer_lines: list[str] = []
        self._candidate: tuple[Settings, list[MuscleOutputs]] | None = None  # accepted, not applied
        self._simulated = self._is_time_simulated()
        settings = self._declare_parameters()
        for text, fault in settings.left_out.items():
            self.get_logger().error(f'muscle {text} is left out: {fault}')
        self._apply(settings, self._open_outputs(settings))
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
        self.get_logger().info(
            f'{", ".join(muscle.name for muscle in self._muscles)}, '
            f'{settings.solvers[0].side} shoulder; '
            f'{settings.convention.name}: {settings.convention.formula}; '
            f'joints {", ".join(settings.joints.names)}, humerus against scapula, rad'
        )
        self._warn_of_convention()
        warn_of_unknown_parameters(self)

    def _declare_parameters(self) -> Settings:
        """Return the settings; log a line if they take long because the solver is compiled."""
        line = 'preparing the solver; the first start compiles it'
        notice = Timer(1.0, self.get_logger().info, [line])
        if COMPILED:
            notice.start()
        try:
            return declare_parameters(self)
        finally:
            notice.cancel()

    def _warn_of_convention(self) -> None:
        """Log what the convention's streams usually measure, if that is not what is needed."""
        if caution := self._settings.convention.caution:
            self.get_logger().warning(caution)

    def _apply(self, settings: Settings, muscles: Sequence[MuscleOutputs]) -> None:
        """Use these settings and answer with these muscles from now on."""
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
        self._memory.timeout = settings.joint_timeout
        self._settings, self._muscles = settings, muscles
        logger = self.get_logger()
        for muscle, solver in zip(muscles, settings.solvers, strict=True):
            own = logger if len(muscles) == 1 else logger.get_child(muscle.name)
            muscle.apply(settings, solver, own)

    def _open_outputs(self, settings: Settings) -> list[MuscleOutputs]:
        """Return the outputs of the settings' muscles, keeping those that are open by name."""
        kept = {muscle.name: muscle for muscle in self._muscles}
        names = [solver.muscle.name for solver in settings.solvers]
        opened: dict[str, MuscleOutputs] = {}
        try:
            with qos.override_errors():
                for name in names:
                    if name not in kept:
                        opened[name] = MuscleOutputs(self, name)
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
            with refusals('parameters'):
                settings = Settings.from_values(self._merge_values(changes), may_fail)
                rehearse(settings)
                self._candidate = settings, self._open_outputs(settings)
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
        if 'joint_convention' in names:
            self._warn_of_convention()

    def _is_time_simulated(self) -> bool:
        return bool(self.get_parameter(USE_SIM_TIME).value)

    def _merge_values(self, changes: list[Parameter]) -> dict[str, Any]:
        values = {name: self.get_parameter(name).value for name in NAMES}
        values.update({change.name: change.value for change in changes})
        return values

    def _answer(self, message: JointState) -> None:
        """Let each muscle answer one joint state, or log why it is rejected."""
        start = perf_counter()
        stamp = message.header.stamp
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
        for muscle in self._muscles:
            start = muscle.answer(stamp, angles, speeds, start)

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
        self._drop_candidate()
        of_input = qos.describe_incompatible_peers(self, self._input)
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
