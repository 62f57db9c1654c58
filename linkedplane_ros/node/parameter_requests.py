# SPDX-License-Identifier: Apache-2.0
"""Requests to set parameters that rclpy itself has no answer to, or one that names nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..errors import describe_value

TYPES = frozenset(each.value for each in Parameter.Type)
RequestHandler = Callable[[Any, Any], Any]
"""From a request of a service and its empty response to the response."""
Refuse = Callable[[ParameterMessage], SetParametersResult | None]


def refuse_odd_requests(node: Node) -> None:
    """Let a node refuse parameters that it does not have, and values of no type, with a reason."""

    def refuse(given: ParameterMessage) -> SetParametersResult | None:
        reason = ''
        if not node.has_parameter(given.name):
            reason = 'undeclared; a parameter of this node expected'
        elif given.value.type not in TYPES:
            reason = (
                f'type {given.value.type} given, {min(TYPES)} to {max(TYPES)} expected '
                '(rcl_interfaces/ParameterType)'
            )
        text = f'parameter {describe_value(given.name)}: {reason}'
        return SetParametersResult(successful=False, reason=text) if reason else None

    for service in node.services:
        if service.srv_type is SetParameters:
            service.callback = _answer_each(service.callback, refuse)
        elif service.srv_type is SetParametersAtomically:
            service.callback = _answer_all(service.callback, refuse)


def _answer_each(answer: RequestHandler, refuse: Refuse) -> RequestHandler:
    def answer_typed(request: Any, response: Any) -> Any:
        refusals = [refuse(each) for each in request.parameters]
        typed = zip(request.parameters, refusals, strict=True)
        request.parameters = [each for each, refusal in typed if refusal is None]
        results = iter(answer(request, response).results)
        response.results = [refusal or next(results) for refusal in refusals]
        return response

    return answer_typed


def _answer_all(answer: RequestHandler, refuse: Refuse) -> RequestHandler:
    def answer_typed(request: Any, response: Any) -> Any:
        refusals = filter(None, map(refuse, request.parameters))
        refusal = next(refusals, None)
        if refusal is None:
            return answer(request, response)
        response.result = refusal
        return response

    return answer_typed
