"""The node muscle_state_publisher: joint states in, muscle states out. Plumbing only."""

from __future__ import annotations

import gc
import sys
from threading import Timer
from time import perf_counter
from typing import Any

import rclpy
from builtin_interfaces.msg import Time
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
from std_msgs.msg import Float64MultiArray, UInt8MultiArray
from visualization_msgs.msg import MarkerArray

from . import parameters, qos
from .compiled import COMPILED
from .conventions import NEAR_SINGULAR, sine_of_singularity
from .conversions import Answers, Floats
from .diagnostics import Tally, diagnostics
from .joint_input import JointMemory, Rejected, Three
from .markers import MuscleMarkers
from .shapes import Pace
from .solver import MuscleState

OUTPUTS = {
    'band_lengths': Float64MultiArray,
    'moment_arms': Float64MultiArray,
    'band_states': JointState,
    'wrap_states': UInt8MultiArray,
    'moment_vectors': Float64MultiArray,
    'markers': MarkerArray,
}
STILL = (0.0, 0.0, 0.0)  # rad/s
THROTTLE = 5.0  # s between lines on rejected messages


class MuscleStatePublisher(Node):
    """Answers every accepted JointState with the state of the muscle."""

    def __init__(self, **kwargs: Any) -> None:
        """Declare parameters and topics; ValueError where a parameter cannot be used."""
        super().__init__('muscle_state_publisher', **kwargs)
        self._tally = Tally()
        self._viewers = 0
        self._outputs: dict[str, Any] = {}
        self._cleared = False
        settings = self._declared()
        with qos.overrides_in_one_line():
            self._apply(settings, self._made_outputs(settings))
        self._diagnostics = self.create_publisher(
            DiagnosticArray,
            '/diagnostics',
            10,
            event_callbacks=PublisherEventCallbacks(use_default_callbacks=False),
        )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0, self._report, clock=steady)
        self.add_on_set_parameters_callback(self._check)
        self.add_post_set_parameters_callback(self._change)
        with qos.overrides_in_one_line():
            self._input = self.create_subscription(
                JointState,
                'joint_states',
                self._answer,
                qos.joint_states(),
                event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
                qos_overriding_options=qos.overridable(),
            )
        settings = self._settings
        self.get_logger().info(
            f'{settings.solver.muscle.name}, {settings.solver.side} shoulder; '
            f'{settings.convention.name}: {settings.convention.formula}; '
            f'joints {", ".join(settings.joints.names)}, humerus against scapula, rad'
        )
        if settings.convention.relative_to != 'scapula':
            self.get_logger().warning(
                f'{settings.convention.name} streams usually measure the humerus against the '
                f'{settings.convention.relative_to}; this node needs it against the scapula'
            )

    def _declared(self) -> parameters.Settings:
        """Return the parameters' settings; say so if the solver has to be compiled for them."""
        line = 'preparing the solver; the first start compiles it'
        notice = Timer(1.0, self.get_logger().info, [line])
        if COMPILED:
            notice.start()
        try:
            return parameters.declare(self)
        finally:
            notice.cancel()

    def _apply(self, settings: parameters.Settings, outputs: dict[str, Any]) -> None:
        """Work with these settings from now on, and publish there."""
        gone = outputs is not self._outputs and self._outputs
        if self._cleared and (gone or not settings.markers_enabled):  # leave no muscle behind
            self._outputs['markers'].publish(self._markers.clear(self._last_stamp))
        for publisher in gone.values() if gone else ():
            self.destroy_publisher(publisher)
        memory = getattr(self, '_memory', None)
        if memory is None or memory.joints != settings.joints:
            self._memory = JointMemory(settings.joints)
        muscle = settings.solver.muscle
        self._settings, self._outputs, self._cleared = settings, outputs, False
        self._tally.last_state = None  # that of other settings
        self._markers = MuscleMarkers(
            muscle, settings.frame_id, settings.markers_points, settings.markers_details
        )
        self._pace = Pace(settings.markers_rate)
        self._answers = Answers(
            muscle.band_names, settings.convention.coordinates, settings.frame_id
        )

    def _made_outputs(self, settings: parameters.Settings) -> dict[str, Any]:
        """Return the publishers, named after the muscle; those there are if it has the name."""
        name = settings.solver.muscle.name
        if self._outputs and self._settings.solver.muscle.name == name:
            return self._outputs
        made: dict[str, Any] = {}
        try:
            for topic, kind in OUTPUTS.items():
                made[topic] = self.create_publisher(
                    kind,
                    f'{name}/{topic}',
                    qos.markers() if topic == 'markers' else qos.answers(),
                    event_callbacks=PublisherEventCallbacks(use_default_callbacks=False),
                    qos_overriding_options=qos.overridable(),
                )
        except RuntimeError:
            for publisher in made.values():
                self.destroy_publisher(publisher)
            raise
        return made

    def _check(self, changes: list[Parameter]) -> SetParametersResult:
        """Accept a batch of parameter changes if the whole of it can be worked with."""
        if not any(change.name in parameters.NAMES for change in changes):
            return SetParametersResult(successful=True)
        try:
            settings = parameters.Settings.from_values(self._values(changes))
            with qos.overrides_in_one_line():
                self._candidate = settings, self._made_outputs(settings)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _change(self, changes: list[Parameter]) -> None:
        """Work with accepted parameters."""
        if any(change.name in parameters.NAMES for change in changes):
            self._apply(*self._candidate)

    def _values(self, changes: list[Parameter]) -> dict[str, Any]:
        values = {name: self.get_parameter(name).value for name in parameters.NAMES}
        values.update({change.name: change.value for change in changes})
        return values

    def _answer(self, message: JointState) -> None:
        """Answer one joint state, or say why not."""
        start = perf_counter()
        tally = self._tally
        tally.received += 1
        tally.last_arrival = start
        try:
            angles, speeds, warning = self._memory.take(
                message.name, message.position, message.velocity
            )
            state, arms, lengthening, axes = self._solve(angles, speeds or STILL)
        except Rejected as error:
            tally.rejected[error.reason] += 1
            tally.last_line = str(error)
            self.get_logger().warning(
                f'joint state not used: {error}', throttle_duration_sec=THROTTLE
            )
            return
        if warning:
            self.get_logger().warning(warning, throttle_duration_sec=THROTTLE)
        tally.solve_times.append(perf_counter() - start)
        stamp = message.header.stamp
        outputs = self._outputs
        for name, answer in self._answers.at(
            stamp, state, arms, None if speeds is None else lengthening
        ).items():
            outputs[name].publish(answer)
        if outputs['markers'].get_subscription_count() and self._pace.due(
            stamp.sec + 1e-9 * stamp.nanosec, start
        ):
            self._show(state, stamp)
        tally.answered += 1
        tally.near_singular += sine_of_singularity(axes) < NEAR_SINGULAR
        tally.last_state, self._last_stamp = state, stamp
        tally.callback_times.append(perf_counter() - start)

    def _solve(self, angles: Three, speeds: Three) -> tuple[MuscleState, Floats, Floats, Floats]:
        """Return the muscle's state, moment arms, lengthening and the coordinates' axes."""
        try:
            return self._settings.solver.answer(self._settings.convention, angles, speeds)
        except ValueError as error:
            raise Rejected('no_plane', str(error)) from None

    def _show(self, state: MuscleState, stamp: Time) -> None:
        """Publish the markers of a state; before the first, remove any that were there."""
        if not self._settings.markers_enabled:
            return
        if not self._cleared:
            self._outputs['markers'].publish(self._markers.clear(stamp))
            self._cleared = True
        self._outputs['markers'].publish(self._markers.at(state, stamp))

    def _show_again(self) -> None:
        """Show the newest state to new viewers if no input is coming (a paused recording)."""
        viewers, before = self._outputs['markers'].get_subscription_count(), self._viewers
        self._viewers = viewers
        state, arrival = self._tally.last_state, self._tally.last_arrival
        if viewers > before and state and arrival and perf_counter() - arrival > 0.5:
            self._show(state, self._last_stamp)

    def _report(self) -> None:
        """Once a second: tell of peers that do not fit, new viewers, and the diagnostics."""
        ends = (self._input, *self._outputs.values())
        lines = [line for end in ends for line in qos.misfits(self, end)]
        for line in lines:
            if line not in self._tally.misfits:
                self.get_logger().warning(line)
        self._tally.misfits = lines
        self._show_again()
        settings = self._settings
        muscle = settings.solver.muscle.name
        facts = {
            'muscle': muscle,
            'scale': settings.scale,
            'side': settings.solver.side,
            'joint convention': settings.convention.name,
            'rotation': settings.convention.formula,
            'joints': ', '.join(settings.joints.names),
            'compiled': 'yes' if COMPILED else 'no',
        }
        self._diagnostics.publish(
            diagnostics(
                self._tally,
                f'{self.get_fully_qualified_name()[1:]}: {muscle}',
                f'{muscle}, {settings.solver.side}',
                self.get_clock().now().to_msg(),
                perf_counter(),
                facts,
            )
        )


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
