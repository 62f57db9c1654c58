# SPDX-License-Identifier: Apache-2.0
"""Settings are tried before they are taken: a message that cannot be sent would end the node."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from rclpy.serialization import serialize_message

from .articulated_frames import tf_message_class
from .markers import MuscleMarkers
from .messages import Answers
from .settings import Settings, refusals


def rehearse(settings: Settings) -> None:
    """Make and pack every message of the settings once.

    Raises
    ------
    LinkedPlaneError
        If one cannot be: a name that is no text, for instance.

    """
    with refusals('parameters'):
        if settings.sources:
            tf_message_class()
        moved = settings.articulations
        still = (0.0,) * len(moved.coordinates)
        for solver, moved_by in zip(settings.solvers, moved.moved_by, strict=False):
            muscle = solver.muscle
            answer = solver.answer(moved_by, still, still)
            answers = Answers(
                muscle.band_names, moved.coordinates, settings.frame_id, solver.bones[1:]
            )
            markers = MuscleMarkers(
                muscle, settings.frame_id, settings.markers_points, settings.markers_details
            )
            of_bones = (answers.update_wrenches(answer.state),) if len(solver.bones) > 2 else ()
            for message in (
                *answers.update(
                    Time(), answer.state, answer.moment_arms, answer.lengthening
                ).values(),
                *of_bones,
                markers.update(answer.state, Time()),
            ):
                serialize_message(message)
