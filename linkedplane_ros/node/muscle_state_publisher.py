"""The node muscle_state_publisher: joint states in, muscle states out. Plumbing only."""

from __future__ import annotations

import gc
import sys
from collections.abc import Sequence
from threading import Timer
from time import perf_counter
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import SetParametersResult
from rclpy._rclpy_pybind11 import RCLError
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.exceptions import InvalidHandle
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

from ..joints.joint_state import JointMemory, Rejected
from ..linked_planes.compiled import COMPILED
from . import qos
from .declaration import declare_parameters
from .outputs import THROTTLE, MuscleOutputs
from .parameters import NAMES
from .settings import Settings
from .topics import DIAGNOSTICS, JOINT_STATES


class MuscleStatePublisher(Node):
    """Answers every accepted JointState with the state of each muscle."""

    def __init__(self, **kwargs: Any) -> None:
        """Declare parameters and topics; ValueError where a parameter cannot be used."""
        super().__init__('muscle_state_publisher', **kwargs)
        self._muscles: Sequence[MuscleOutputs] = ()
        self._misfits: list[str] = []
        settings = self._declared()
        for text, fault in settings.left_out.items():
            self.get_logger().error(f'muscle {text} is left out: {fault}')
        self._apply(settings, self._with_topics(settings))
        self._diagnostics = self.create_publisher(
            DiagnosticArray,
            DIAGNOSTICS.name,
            qos.profile(DIAGNOSTICS),
            event_callbacks=PublisherEventCallbacks(use_default_callbacks=False),
        )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0, self._report, clock=steady)
        self.add_on_set_parameters_callback(self._check)
        self.add_post_set_parameters_callback(self._change)
        with qos.overrides_in_one_line():
            self._input = self.create_subscription(
                JointState,
                JOINT_STATES.name,
                self._answer,
                qos.profile(JOINT_STATES),
                event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
                qos_overriding_options=qos.overridable(),
            )
        self.get_logger().info(
            f'{", ".join(muscle.name for muscle in self._muscles)}, '
            f'{settings.solvers[0].side} shoulder; '
            f'{settings.convention.name}: {settings.convention.formula}; '
            f'joints {", ".join(settings.joints.names)}, humerus against scapula, rad'
        )
        if settings.convention.relative_to != 'scapula':
            self.get_logger().warning(
                f'{settings.convention.name} streams usually measure the humerus against the '
                f'{settings.convention.relative_to}; this node needs it against the scapula'
            )

    def _declared(self) -> Settings:
        """Return the parameters' settings; say so if the solver has to be compiled for them."""
        line = 'preparing the solver; the first start compiles it'
        notice = Timer(1.0, self.get_logger().info, [line])
        if COMPILED:
            notice.start()
        try:
            return declare_parameters(self)
        finally:
            notice.cancel()

    def _apply(self, settings: Settings, muscles: Sequence[MuscleOutputs]) -> None:
        """Work with these settings from now on, and answer with these muscles."""
        if len(muscles) == len(self._muscles) == 1:  # another one in its place goes on counting
            muscles[0].tally = self._muscles[0].tally
        for gone in self._muscles:
            if gone not in muscles:
                gone.close()
        if not hasattr(self, '_memory') or self._memory.joints != settings.joints:
            self._memory = JointMemory(settings.joints)
        self._settings, self._muscles = settings, muscles
        logger = self.get_logger()
        for muscle, solver in zip(muscles, settings.solvers, strict=True):
            own = logger if len(muscles) == 1 else logger.get_child(muscle.name)
            muscle.apply(settings, solver, own)

    def _with_topics(self, settings: Settings) -> list[MuscleOutputs]:
        """Return the muscles of the settings; those there are where they have the name."""
        there = {muscle.name: muscle for muscle in self._muscles}
        names = [solver.muscle.name for solver in settings.solvers]
        made: dict[str, MuscleOutputs] = {}
        try:
            with qos.overrides_in_one_line():
                for name in names:
                    if name not in there:
                        made[name] = MuscleOutputs(self, name)
        except ValueError:
            for muscle in made.values():
                muscle.close()
            raise
        return [there.get(name) or made[name] for name in names]

    def _check(self, changes: list[Parameter]) -> SetParametersResult:
        """Accept a batch of parameter changes if the whole of it can be worked with."""
        names = {change.name for change in changes}
        if names.isdisjoint(NAMES):
            return SetParametersResult(successful=True)
        may_fail = () if 'muscle' in names else self._settings.left_out
        try:
            settings = Settings.from_values(self._values(changes), may_fail)
            self._candidate = settings, self._with_topics(settings)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _change(self, changes: list[Parameter]) -> None:
        """Work with accepted parameters."""
        if any(change.name in NAMES for change in changes):
            self._apply(*self._candidate)

    def _values(self, changes: list[Parameter]) -> dict[str, Any]:
        values = {name: self.get_parameter(name).value for name in NAMES}
        values.update({change.name: change.value for change in changes})
        return values

    def _answer(self, message: JointState) -> None:
        """Let each muscle answer one joint state, or say why it was not taken in."""
        start = perf_counter()
        try:
            angles, speeds, warning = self._memory.take(
                message.name, message.position, message.velocity
            )
        except Rejected as error:
            for muscle in self._muscles:
                muscle.reject(error, start)
            self.get_logger().warning(
                f'joint state not used: {error}', throttle_duration_sec=THROTTLE
            )
            return
        if warning:
            self.get_logger().warning(warning, throttle_duration_sec=THROTTLE)
        stamp = message.header.stamp
        for muscle in self._muscles:
            start = muscle.answer(stamp, angles, speeds, start)

    def _report(self) -> None:
        """Once a second: tell of peers that do not fit, new viewers, and the diagnostics."""
        misfits = qos.misfits(self, self._input)
        lines = list(misfits)
        for muscle in self._muscles:
            lines += muscle.look_at_peers(misfits)[len(misfits) :]
        for line in lines:
            if line not in self._misfits:
                self.get_logger().warning(line)
        self._misfits = lines
        for muscle in self._muscles:
            muscle.show_again()
        array = DiagnosticArray(status=[muscle.status() for muscle in self._muscles])
        array.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(array)


def main(args: list[str] | None = None) -> None:
    """Run the node until it is interrupted or terminated; either ends it with status 0."""
    rclpy.init(args=args)
    node = None
    try:
        executor = SingleThreadedExecutor()  # now: making one fails noisily after a signal
        node = MuscleStatePublisher()
        executor.add_node(node)
        gc.collect()
        gc.freeze()  # what is loaded by now stays: to look through it again takes tens of ms
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except ValueError as error:
        sys.exit(f'muscle_state_publisher: {error}')
    except (RCLError, InvalidHandle):
        if rclpy.ok():  # else the signal came in the middle of a call
            raise
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
