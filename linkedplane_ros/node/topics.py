# SPDX-License-Identifier: Apache-2.0
"""The node's topics: what it subscribes and publishes, for the node and for its documentation.

No ROS is needed here: message types are named, as `std_msgs/msg/Float64MultiArray`.
"""

from __future__ import annotations

from collections.abc import Iterable

from ..processing.topics import ANSWERS, MARKERS, WRENCHES, Topic
from ..recordings.bags.topics import JOINT_STATE

NODE_NAME = 'muscle_state_publisher'
JOINT_STATES = Topic(
    'joint_states',
    JOINT_STATE,
    'The three **glenohumeral** angles, rad: humerus against scapula (with a rhythm: against the '
    'thorax), or the joints of a skeleton, rad or m. Joints are found by name, in any order, among '
    'any others; they may come in several messages, and the newest value of each counts.',
    reliability='best_effort',  # takes what any publisher offers
    depth=100,
)
ROBOT_DESCRIPTION = Topic(
    'robot_description',
    'std_msgs/msg/String',
    'Where the parameter `skeleton` is `robot_description`: the URDF, as robot_state_publisher '
    'latches it. Another one is used from then on; one that cannot be used changes nothing.',
    depth=1,
    latched=True,
)
TF = Topic(
    '/tf',
    'tf2_msgs/msg/TFMessage',
    'Where the parameter `input` is `tf`: the frames of the bones, in place of joint states. All '
    'of a stamp are answered together, once; the newest of a frame that is slower counts.',
    depth=100,
)
TF_STATIC = Topic(
    '/tf_static',
    'tf2_msgs/msg/TFMessage',
    'With `/tf`: frames that hold for all times, in one tree with the others.',
    depth=100,
    latched=True,
)
CLOCK = Topic(
    '/clock',
    'rosgraph_msgs/msg/Clock',
    'Under `use_sim_time`; it dates the diagnostics, and the arrival of joints for their ages.',
    reliability='best_effort',
    depth=1,
)
DIAGNOSTICS = Topic(
    '/diagnostics',
    'diagnostic_msgs/msg/DiagnosticArray',
    'Once a second, for each muscle: messages received, answered, of other joints, and rejected by '
    'reason; solve and callback times (mean, 99th percentile, worst); the age of the input, and of '
    "each joint's value; theta and wrap states; convention, muscle, compiled or not; answers near "
    'the singularity, with a joint of the skeleton beyond its limits by more than a tenth of its '
    'range, at poses outside the range of motion, and with a moment arm beyond its bound '
    "(3 times the insertion's distance from the joint); peers whose quality of service does not "
    'fit. OK; WARN: in the last second something was rejected, a moment arm was beyond its bound, '
    'or more than a tenth of the poses or joints were outside; a joint is older than 3 s, or than '
    '`joint_timeout`; a peer does not fit; another node has the same name; ERROR: nothing was '
    'usable so far; STALE: no input yet, or none for 3 s.',
    depth=10,
)
OUTPUTS = (*ANSWERS, MARKERS)
"""The topics of each muscle, under its name."""
BONE_OUTPUTS = (WRENCHES,)
"""Those of muscles of more than two bones, beside them."""


def topic_rows(topics: Iterable[Topic], prefix: str = '') -> list[tuple[str, str, str, str]]:
    """Return the rows of a table of topics for the documentation, in Markdown.

    Parameters
    ----------
    topics
        `(JOINT_STATES, CLOCK)` are subscribed; `OUTPUTS`, with a muscle's name and a slash as
        prefix, and `(DIAGNOSTICS,)` are published.
    prefix
        What stands before each name.

    Returns
    -------
    list of (str, str, str, str)
        Topic, type, quality of service and meaning.

    """
    return [
        (
            f'`{prefix}{topic.name}`',
            topic.type.replace('/msg/', '/'),
            f'{topic.reliability.replace("_", " ")}, depth {topic.depth}'
            + ', transient local' * topic.latched,
            topic.meaning + ' Only while somebody subscribes.' * topic.on_demand,
        )
        for topic in topics
    ]
