# SPDX-License-Identifier: Apache-2.0
"""A muscle's topics: names, types, what is on them, and the labels of their arrays.

The node publishes them and `linkedplane process` records them; both, and the documentation, read
this table.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..recordings.bags.topics import JOINT_STATE

BAND, COORDINATE, AXIS = 'band', 'coordinate', 'axis'
BONE, COMPONENT = 'bone', 'component'
COMPONENTS = ('mx', 'my', 'mz', 'fx', 'fy', 'fz')
FLOAT_ARRAY, UINT8_ARRAY = 'std_msgs/msg/Float64MultiArray', 'std_msgs/msg/UInt8MultiArray'


@dataclass(frozen=True)
class Topic:
    """One topic, its type, its content and its quality of service."""

    name: str
    """Of a muscle's topics: relative to the muscle's name."""
    type: str
    """As ROS names it, `package/msg/Name`."""
    meaning: str
    """One or more sentences of Markdown."""
    dimensions: tuple[str, ...] = ()
    """Of an array: the kinds of its dimensions, as its labels name them."""
    reliability: str = 'reliable'
    """`reliable` or `best_effort`."""
    depth: int = 2000
    """Messages in the queue: at 500 Hz, what a reader may lose in a heartbeat (3 s) comes again."""
    on_demand: bool = False
    """Whether the node publishes it only while somebody subscribes."""
    latched: bool = False
    """Whether the newest message is kept for subscribers that come later (transient local)."""


ANSWERS = (
    Topic('band_lengths', FLOAT_ARRAY, '(n,) length of each band, m.', (BAND,)),
    Topic(
        'moment_arms',
        FLOAT_ARRAY,
        "(n, 3) moment arms, m, row-major, a column for each of the convention's coordinates, or "
        '(n, d) for the joints of a skeleton; about an angle against the thorax they include what '
        'the rhythm lets follow. '
        "**Positive: shortening turns the joint in the coordinate's positive direction** "
        "(r = -dL/dq, OpenSim's sign).",
        (BAND, COORDINATE),
    ),
    Topic(
        'band_states',
        JOINT_STATE,
        'The bands as joints, for tools that plot by name: position = length, m; velocity = '
        'lengthening speed, m/s, empty if the input has no velocities.',
    ),
    Topic(
        'wrap_states',
        UINT8_ARRAY,
        '(n,) 0 wrapped, 1 clear (straight: its plane cuts the sphere, the line keeps off it), '
        '2 missed (straight: its plane does not reach the sphere), 3 inside (an end lies in the '
        'sphere: no path, a straight line instead).',
        (BAND,),
    ),
    Topic(
        'moment_vectors',
        FLOAT_ARRAY,
        '(n, 3) moment vectors, m, row-major: -dL/domega about the axes x, y, z of the scapula '
        "frame (of a muscle of several bones: the last bone's, about the ground). Moment arms that "
        'need no convention and have no singularity.',
        (BAND, AXIS),
    ),
    Topic(
        'moment_arm_states',
        JOINT_STATE,
        'The moment arms as joints, for tools that plot by name. A name is a band and one of the '
        'coordinates, as in `anterior_1/flexion`, in the order of `moment_arms`; '
        'position = moment arm, m, of the same sign.',
        on_demand=True,
    ),
)
"""One message on each, in this order, for every joint state that is used."""

WRENCHES = Topic(
    'wrenches',
    FLOAT_ARRAY,
    '(n, k, 6) what each band, at unit tension, does to each bone that moves, row-major: the '
    "moment, m, and the force, 1, about the ground bone's origin and axes; of muscles of more than "
    'two bones. Times how a joint moves the bones, they are its moment arms.',
    (BAND, BONE, COMPONENT),
    on_demand=True,
)

MARKERS = Topic(
    'markers',
    'visualization_msgs/msg/MarkerArray',
    'Namespaces `bands`, `attachments`, `bones` (all that move, where they are), '
    '`obstacle_spheres`, `planes` (of the bands), `interference_spheres` and '
    '`interferences` (where a band is deepest in one of them).',
    depth=10,
    on_demand=True,
)


def dimension_names(
    bands: Sequence[str], coordinates: Sequence[str], bones: Sequence[str] = ()
) -> dict[str, Sequence[str]]:
    """Return what each kind of dimension counts, by name; `bones` are those that move."""
    axes = ('x', 'y', 'z')
    return {BAND: bands, COORDINATE: coordinates, AXIS: axes, BONE: bones, COMPONENT: COMPONENTS}


def wrench_names(bands: Sequence[str], bones: Sequence[str]) -> list[str]:
    """Return the name of each number, `band/bone/component`, in the order of `wrenches`."""
    return [f'{band}/{bone}/{each}' for band in bands for bone in bones for each in COMPONENTS]


def moment_arm_names(bands: Sequence[str], coordinates: Sequence[str]) -> list[str]:
    """Return the name of each moment arm, `band/coordinate`, in the order of `moment_arms`."""
    return [f'{band}/{coordinate}' for band in bands for coordinate in coordinates]


def label_dimensions(*dimensions: tuple[str, Sequence[str]]) -> list[tuple[str, int, int]]:
    """Return label, size and stride of each dimension of a row-major array.

    Parameters
    ----------
    dimensions
        The kind and the names of each, from the outermost inwards.

    Returns
    -------
    list of (str, int, int)
        A label is the kind and the names, as in `band:anterior_1,anterior_2`; a stride is the
        number of values from its dimension inwards (MultiArrayLayout.msg).

    """
    sizes = [len(names) for _, names in dimensions]
    return [
        (f'{kind}:{",".join(names)}', len(names), math.prod(sizes[i:]))
        for i, (kind, names) in enumerate(dimensions)
    ]


def read_label(label: str) -> tuple[str, tuple[str, ...]]:
    """Return the kind and the names in a dimension's label."""
    kind, _, names = label.partition(':')
    return kind, tuple(names.split(','))
