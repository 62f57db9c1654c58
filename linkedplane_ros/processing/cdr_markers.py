# SPDX-License-Identifier: Apache-2.0
"""The markers as a recording holds them: CDR bytes, without ROS; the same as the node's."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from ..drawing.shapes import MuscleShapes, Placement, Shape
from ..muscle.broad_muscle import BroadMuscle
from ..solver.states import MuscleState
from ..types import Colour, Floats
from .cdr import STAMP, MessageTemplate, split_stamps
from .topics import MARKERS


class MarkerSerializer:
    """Serialises the markers of one muscle; those of states that wrap alike have one template.

    Parameters
    ----------
    store
        The type store of rosbags.
    muscle
        What is drawn.
    frame_id
        Of the headers.
    points
        How many points there are on the arc of a wrapped band.
    """

    def __init__(self, store: Any, muscle: BroadMuscle, frame_id: str, points: int) -> None:
        """Describe the shapes; templates are made when they are needed."""
        self._store, self._frame_id = store, frame_id
        self._shapes = MuscleShapes(muscle, points, details=False)
        self._templates: dict[bytes, MessageTemplate] = {}

    def serialize(self, states: Sequence[MuscleState], stamps: Sequence[int]) -> list[bytes]:
        """Return the message at each state; stamps in ns."""
        made = [b''] * len(states)
        alike = defaultdict(list)
        for k, state in enumerate(states):
            alike[state.wrap.tobytes()].append(k)
        for wrap, which in alike.items():
            places = [self._shapes.placements(states[k]) for k in which]
            if wrap not in self._templates:
                self._templates[wrap] = self._template(places[0])
            arrays = [dict(named_arrays(each)) for each in places]
            values = {name: np.stack([each[name] for each in arrays]) for name in arrays[0]}
            now = split_stamps(np.array([stamps[k] for k in which]))
            messages = self._templates[wrap].fill(len(which), stamp=now, **values)
            for k, message in zip(which, messages, strict=True):
                made[k] = message
        return made

    def _template(self, places: Sequence[Placement]) -> MessageTemplate:
        """Return the template of such placements, with random numbers as examples."""
        random = np.random.default_rng(0).random
        examples = []
        for place in places:
            position, turn, points = (
                None if each is None else random(each.shape) for each in place.numbers
            )
            examples.append(Placement(position, turn, points))
        markers = [
            self._marker(shape, example, place.action)
            for shape, example, place in zip(self._shapes.shapes, examples, places, strict=True)
        ]
        message = self._store.types[MARKERS.type](markers=markers)
        data = bytes(self._store.serialize_cdr(message, MARKERS.type))
        return MessageTemplate(data, stamp=STAMP, **dict(named_arrays(examples)))

    def _marker(self, shape: Shape, place: Placement, action: int) -> Any:
        def make(kind: str, *values: Any) -> Any:
            return self._store.types[kind](*values)

        def points(rows: Iterable[Floats]) -> list[Any]:
            return [make('geometry_msgs/msg/Point', *row) for row in rows]

        def colour(rgb: Colour, alpha: float) -> Any:
            return make('std_msgs/msg/ColorRGBA', *rgb, alpha)

        now = make('builtin_interfaces/msg/Time', *STAMP.tolist())
        none = make('builtin_interfaces/msg/Time', 0, 0)
        unnamed = make('std_msgs/msg/Header', none, '')
        nothing = np.empty(0, np.uint8)
        [position] = points([np.zeros(3) if place.position is None else place.position])
        turn = (0.0, 0.0, 0.0, 1.0) if place.orientation is None else place.orientation
        return self._store.types['visualization_msgs/msg/Marker'](
            header=make('std_msgs/msg/Header', now, self._frame_id),
            ns=shape.namespace,
            id=shape.number,
            type=shape.kind,
            action=action,
            pose=make(
                'geometry_msgs/msg/Pose', position, make('geometry_msgs/msg/Quaternion', *turn)
            ),
            scale=make('geometry_msgs/msg/Vector3', *shape.scale),
            color=colour(shape.colour, shape.alpha),
            lifetime=make('builtin_interfaces/msg/Duration', 0, 0),
            frame_locked=True,
            points=points(() if place.points is None else place.points),
            colors=[colour(each, 1.0) for each in shape.colours],
            texture_resource='',
            texture=make('sensor_msgs/msg/CompressedImage', unnamed, '', nothing),
            uv_coordinates=[],
            text='',
            mesh_resource='',
            mesh_file=make('visualization_msgs/msg/MeshFile', '', nothing),
            mesh_use_embedded_materials=False,
        )


def named_arrays(places: Sequence[Placement]) -> Iterator[tuple[str, Floats]]:
    """Yield all arrays of the placements, each under a name of its own."""
    for k, place in enumerate(places):
        for name, each in zip(Placement._fields, place.numbers, strict=False):
            if each is not None:
                yield f'{name}_{k}', each
