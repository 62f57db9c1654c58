# SPDX-License-Identifier: Apache-2.0
"""Settings are tried before they are taken: a message that cannot be sent would end the node."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from rclpy.serialization import serialize_message

from .markers import MuscleMarkers
from .messages import Answers
from .settings import STILL, Settings, refusals


def rehearse(settings: Settings) -> None:
    """Make and pack every message of the settings once.

    Raises
    ------
    LinkedPlaneError
        If one cannot be: a name that is no text, for instance.

    """
    with refusals('parameters'):
        for solver in settings.solvers:
            muscle, convention = solver.muscle, settings.convention
            answer = solver.answer(convention, STILL, STILL)
            answers = Answers(muscle.band_names, convention.coordinates, settings.frame_id)
            markers = MuscleMarkers(
                muscle, settings.frame_id, settings.markers_points, settings.markers_details
            )
            for message in (
                *answers.update(
                    Time(), answer.state, answer.moment_arms, answer.lengthening
                ).values(),
                markers.update(answer.state, Time()),
            ):
                serialize_message(message)
