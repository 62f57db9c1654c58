"""The node muscle_state_publisher: joint states in, muscle states out. Plumbing only."""

from __future__ import annotations

import math
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
from rclpy.exceptions import InvalidHandle
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, UInt8MultiArray
from visualization_msgs.msg import MarkerArray

from . import parameters
from .compiled import COMPILED
from .conversions import Floats, band_states, byte_array, float_array, layout
from .diagnostics import Tally, diagnostics
from .joint_input import JointMemory, Rejected
from .markers import MuscleMarkers
from .solver import MuscleState

INPUT_QOS = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
# deep enough at 500 Hz to give a reader again what it lost up to a heartbeat (3 s) ago
OUTPUT_QOS = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE)
MARKERS_QOS = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
THROTTLE = 5.0  # s between lines on rejected messages


class MuscleStatePublisher(Node):
    """Answers every accepted JointState with the state of the muscle."""

    def __init__(self, **kwargs: Any) -> None:
        """Declare parameters and topics; ValueError where a parameter cannot be used."""
        super().__init__('muscle_state_publisher', **kwargs)
        self._apply(self._declared())
        self._tally = Tally()
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0, self._report, clock=steady)
        self.add_on_set_parameters_callback(self._check)
        self.add_post_set_parameters_callback(self._change)
        self.create_subscription(
            JointState,
            'joint_states',
            self._answer,
            INPUT_QOS,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
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
        notice = Timer(1.0, self.get_logger().info, ['compiling the solver for this machine'])
        if COMPILED:
            notice.start()
        try:
            return parameters.declare(self)
        finally:
            notice.cancel()

    def _apply(self, settings: parameters.Settings) -> None:
        """Work with these settings from now on."""
        memory = getattr(self, '_memory', None)
        if memory is None or memory.joints != settings.joints:
            self._memory = JointMemory(settings.joints)
        self._settings = settings
        muscle = settings.solver.muscle
        self._markers = MuscleMarkers(muscle, settings.frame_id, settings.markers_points)
        self._last_markers = -math.inf
        bands = ('band', muscle.band_names)
        self._bands_layout = layout(bands)
        self._arms_layout = layout(bands, ('coordinate', settings.convention.coordinates))
        self._advertise(muscle.name)

    def _advertise(self, muscle: str) -> None:
        """Create the output topics, named after the muscle, unless they are there already."""
        self._cleared = False
        if getattr(self, '_prefix', None) == muscle:
            return
        if hasattr(self, '_prefix'):
            for publisher in self._outputs:
                self.destroy_publisher(publisher)
        self._prefix = muscle
        self._outputs = [
            self.create_publisher(
                kind,
                f'{muscle}/{topic}',
                MARKERS_QOS if kind is MarkerArray else OUTPUT_QOS,
                qos_overriding_options=QoSOverridingOptions.with_default_policies(),
            )
            for topic, kind in (
                ('band_lengths', Float64MultiArray),
                ('moment_arms', Float64MultiArray),
                ('band_states', JointState),
                ('wrap_states', UInt8MultiArray),
                ('markers', MarkerArray),
            )
        ]

    def _check(self, changes: list[Parameter]) -> SetParametersResult:
        """Accept a batch of parameter changes if the whole of it can be worked with."""
        if not any(change.name in parameters.NAMES for change in changes):
            return SetParametersResult(successful=True)
        try:
            self._candidate = parameters.Settings.from_values(self._values(changes))
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _change(self, changes: list[Parameter]) -> None:
        """Work with accepted parameters."""
        if any(change.name in parameters.NAMES for change in changes):
            self._apply(self._candidate)

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
        settings = self._settings
        try:
            angles, speeds, warning = self._memory.take(
                message.name, message.position, message.velocity
            )
            state, axes = self._solve(angles)
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
        arms = state.moment_vectors @ axes
        stamp = message.header.stamp
        names = settings.solver.muscle.band_names
        lengthening = None if speeds is None else -arms @ speeds
        lengths_out, arms_out, states_out, wrap_out, markers_out = self._outputs
        lengths_out.publish(float_array(self._bands_layout, state.lengths))
        arms_out.publish(float_array(self._arms_layout, arms))
        states_out.publish(band_states(stamp, settings.frame_id, names, state.lengths, lengthening))
        wrap_out.publish(byte_array(self._bands_layout, state.wrap))
        if self._markers_due(stamp):
            if not self._cleared:
                markers_out.publish(self._markers.clear(stamp))
                self._cleared = True
            markers_out.publish(self._markers.at(state, stamp))
        tally.answered += 1
        tally.last_state = state
        tally.callback_times.append(perf_counter() - start)

    def _solve(self, angles: Floats) -> tuple[MuscleState, Floats]:
        """Return the muscle's state and the coordinates' axes at three angles."""
        solver = self._settings.solver
        rotation, axes = self._settings.convention.rotation_and_axes(angles, solver.side)
        try:
            return solver.solve(rotation), axes
        except ValueError as error:
            raise Rejected('no_plane', str(error)) from None

    def _markers_due(self, stamp: Time) -> bool:
        """Return whether markers are wanted and their rate, by the input's stamps, allows them.

        Time that jumps backwards starts anew. An input without stamps is limited by its arrival.
        """
        settings = self._settings
        if not settings.markers_enabled or not self._outputs[-1].get_subscription_count():
            return False
        now = stamp.sec + 1e-9 * stamp.nanosec or perf_counter()
        passed = now - self._last_markers
        if settings.markers_rate and 0.0 <= passed < 1.0 / settings.markers_rate - 1e-6:
            return False
        self._last_markers = now
        return True

    def _report(self) -> None:
        settings = self._settings
        muscle = settings.solver.muscle.name
        facts = {
            'muscle': muscle,
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
