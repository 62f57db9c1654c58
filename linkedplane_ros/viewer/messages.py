# SPDX-License-Identifier: Apache-2.0
"""What a browser may send: a change of a control, its camera, a picture that it was asked for.

viser takes any message of its own, for any property of a control, and converts values as they come:
NaN, `'nan'` or a number beyond a slider's range would reach the arm.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ..errors import describe_value
from .names import short_name

CHANGE, CAMERA, PICTURE = 'GuiUpdateMessage', 'ViewerCameraMessage', 'GetRenderResponseMessage'
VECTORS = {'wxyz': 4, 'position': 3, 'look_at': 3, 'up_direction': 3}  # of a camera
ANSWER = ('payload', 'render_uuid')  # of a picture
NUMBERS = ('fov', 'near', 'far')
PIXELS = ('image_height', 'image_width')
FARTHEST = 1e6  # units of the scene
LARGEST = 1 << 15  # px


def find_message_fault(message: str | bytes, controls: Mapping[str, Any]) -> str:
    """Return what is wrong with a message of a browser, or nothing.

    Parameters
    ----------
    message
        As it came.
    controls
        The library's handles of what a browser can change, by their identifiers.

    """
    import msgspec

    try:
        content = msgspec.msgpack.decode(message) if isinstance(message, bytes) else None
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        content = None
    if not isinstance(content, dict):
        return 'it is no message of this page'
    kind = content.pop('type', None)
    if kind == CHANGE and set(content) == {'uuid', 'updates'}:
        return find_change_fault(content['uuid'], content['updates'], controls)
    if kind == CAMERA and set(content) == {*VECTORS, *NUMBERS, *PIXELS}:
        return '' if is_camera(content) else 'a camera has finite numbers within the scene'
    if kind == PICTURE and [*map(type, map(content.get, ANSWER))] == [bytes, str]:
        return '' if len(content) == len(ANSWER) else 'a picture has two parts'
    return f'this page sends no {describe_value(kind)} of these parts'


def find_change_fault(uuid: Any, updates: Any, controls: Mapping[str, Any]) -> str:
    """Return what is wrong with the change of a control, or nothing."""
    if not isinstance(uuid, str) or not isinstance(updates, dict) or list(updates) != ['value']:
        return 'a control has only its value changed'
    handle = controls.get(uuid)
    if handle is None:  # a page that is not up to date; the library ignores it
        return ''
    value, name = updates['value'], short_name(str(handle.label))
    if handle.disabled or not handle.visible:
        return f'{name}: it cannot be changed now'
    low, high = getattr(handle, 'min', None), getattr(handle, 'max', None)
    if low is not None and high is not None:
        if is_number(value) and low <= value <= high:
            return ''
        return f'{name}: a number from {low:g} to {high:g} expected, not {describe_value(value)}'
    options = getattr(handle, 'options', None)
    if options is not None:
        known = isinstance(value, str) and value in options
        return '' if known else f'{name}: no such choice: {describe_value(value)}'
    return '' if isinstance(value, bool) else f'{name}: true or false expected'


def is_number(value: Any) -> bool:
    """Return whether a value is a finite number."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def is_camera(content: Mapping[str, Any]) -> bool:
    """Return whether a message has the numbers of a camera."""
    rows = [content[name] for name in VECTORS]
    if not all(isinstance(row, list) for row in rows) or [*map(len, rows)] != [*VECTORS.values()]:
        return False
    numbers = [*(each for row in rows for each in row), *(content[name] for name in NUMBERS)]
    if not all(is_number(each) and abs(each) <= FARTHEST for each in numbers):
        return False
    return all(is_number(content[name]) and 0 <= content[name] <= LARGEST for name in PIXELS)
