"""From a muscle state to messages: pure functions of message types, no node."""

from __future__ import annotations

from array import array
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from builtin_interfaces.msg import Time
from sensor_msgs.msg import JointState
from std_msgs.msg import (
    Float64MultiArray,
    Header,
    MultiArrayDimension,
    MultiArrayLayout,
    UInt8MultiArray,
)

Floats = npt.NDArray[np.float64]


def layout(*dimensions: tuple[str, Sequence[str]]) -> MultiArrayLayout:
    """Return a row-major layout; each dimension's label is its kind and its names.

    As in `band:anterior_1,anterior_2`, so that a recording explains itself. The stride of a
    dimension is the number of values from it inwards (MultiArrayLayout.msg).
    """
    sizes = [len(names) for _, names in dimensions]
    return MultiArrayLayout(
        dim=[
            MultiArrayDimension(
                label=f'{kind}:{",".join(names)}',
                size=len(names),
                stride=int(np.prod(sizes[i:])),
            )
            for i, (kind, names) in enumerate(dimensions)
        ]
    )


def float_array(form: MultiArrayLayout, values: Floats) -> Float64MultiArray:
    """Return values of any shape as a message, row-major."""
    return Float64MultiArray(layout=form, data=array('d', np.ascontiguousarray(values).tobytes()))


def byte_array(form: MultiArrayLayout, values: npt.NDArray[np.uint8]) -> UInt8MultiArray:
    """Return small whole numbers as a message."""
    return UInt8MultiArray(layout=form, data=array('B', values.tobytes()))


def band_states(
    stamp: Time, frame_id: str, names: Sequence[str], lengths: Floats, speeds: Floats | None
) -> JointState:
    """Return bands as joints: position their lengths (n,) m, velocity their lengthening (n,) m/s.

    The velocity is empty where speeds is None; the effort always.
    """
    return JointState(
        header=Header(stamp=stamp, frame_id=frame_id),
        name=list(names),
        position=array('d', lengths.tobytes()),
        velocity=array('d', b'' if speeds is None else speeds.tobytes()),
    )
