# SPDX-License-Identifier: Apache-2.0
"""The declaration of the parameters on a ROS node, with their descriptors."""

from __future__ import annotations

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter

from .parameters import SPECS, ParameterSpec
from .rehearsal import rehearse
from .settings import Settings, list_muscles


def declare_parameters(node: Node) -> Settings:
    """Declare every parameter on a node and return its settings.

    A muscle that cannot be loaded is left out as long as another one is left.

    The values are checked before the descriptors are set: what rclpy says of a value out of range
    does not name it.

    Raises
    ------
    LinkedPlaneError
        As `Settings.from_values`.

    """
    free = ParameterDescriptor(dynamic_typing=True)
    values = {}
    for spec in SPECS:
        value = node.declare_parameter(spec.name, spec.default, free).value
        if value is None:  # rcl drops the type of a list that is empty, and with it the list
            value = []
            node.set_parameters([Parameter(spec.name, Parameter.Type.STRING_ARRAY, value)])
        values[spec.name] = value
    settings = Settings.from_values(values, may_fail=list_muscles(values['muscle']))
    rehearse(settings)
    for spec in SPECS:
        node.set_descriptor(spec.name, describe(spec))
    return settings


def describe(spec: ParameterSpec) -> ParameterDescriptor:
    """Return what `ros2 param describe` shows; dynamic, so that a double may be a whole number."""
    descriptor = ParameterDescriptor(
        name=spec.name,
        type=Parameter.Type.from_parameter_value(spec.default).value,
        description=spec.meaning,
        dynamic_typing=True,
        additional_constraints=f'one of: {", ".join(spec.choices)}' if spec.choices else '',
    )
    if spec.low is not None and spec.high is not None:
        if isinstance(spec.default, int):
            descriptor.integer_range = [
                IntegerRange(from_value=int(spec.low), to_value=int(spec.high), step=1)
            ]
        else:
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=spec.low, to_value=spec.high, step=0.0)
            ]
    return descriptor
