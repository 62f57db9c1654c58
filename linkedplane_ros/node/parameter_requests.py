# SPDX-License-Identifier: Apache-2.0
"""Requests to set parameters that rclpy itself has no answer to, or one that names nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.exceptions import ParameterNotDeclaredException
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..errors import describe_value

TYPES = frozenset(each.value for each in Parameter.Type)
Answer = Callable[[Any, Any], Any]
"""From a request of a service and its empty response to the response."""


def refuse_odd_requests(node: Node) -> None:
    """Let a node refuse parameters that it does not have, and values of no type, with a reason."""

    def check_names(changes: list[Parameter]) -> list[Parameter]:
        unknown = [each.name for each in changes if not node.has_parameter(each.name)]
        if unknown:
            raise ParameterNotDeclaredException(unknown)
        return changes

    node.add_pre_set_parameters_callback(check_names)
    for service in node.services:
        if service.srv_type is SetParameters:
            service.callback = _answer_each(service.callback)
        elif service.srv_type is SetParametersAtomically:
            service.callback = _answer_all(service.callback)


def _answer_each(answer: Answer) -> Answer:
    def answer_typed(request: Any, response: Any) -> Any:
        refusals = [_refuse_type(each) for each in request.parameters]
        typed = zip(request.parameters, refusals, strict=True)
        request.parameters = [each for each, refusal in typed if refusal is None]
        results = iter(answer(request, response).results)
        response.results = [refusal or next(results) for refusal in refusals]
        return response

    return answer_typed


def _answer_all(answer: Answer) -> Answer:
    def answer_typed(request: Any, response: Any) -> Any:
        refusals = filter(None, map(_refuse_type, request.parameters))
        refusal = next(refusals, None)
        if refusal is None:
            return answer(request, response)
        response.result = refusal
        return response

    return answer_typed


def _refuse_type(given: ParameterMessage) -> SetParametersResult | None:
    if given.value.type in TYPES:
        return None
    return SetParametersResult(
        successful=False,
        reason=f'parameter {describe_value(given.name)}: type {given.value.type} given, '
        f'{min(TYPES)} to {max(TYPES)} expected (rcl_interfaces/ParameterType)',
    )
