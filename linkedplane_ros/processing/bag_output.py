# SPDX-License-Identifier: Apache-2.0
"""An annotated bag: what was recorded, and the muscle's topics among it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from ..drawing.shapes import MARKER_RATE, POINTS_ON_ARC, RateLimiter
from ..errors import RecordingError
from ..recordings.bags.connections import Connection
from ..recordings.bags.opening import open_bag
from ..recordings.bags.topics import JOINT_STATE
from .bag_writing.topic_facts import kept_topic, new_topic
from .bag_writing.writer import BagWriter
from .cdr import AnswerSerializer, JointStateSerializer, answer_topics
from .cdr_markers import MarkerSerializer
from .outputs import OutputDescription, SolvedChunk
from .topics import MARKERS


class BagOutput:
    """A bag's own messages, byte for byte, and the muscle's topics among them.

    Parameters
    ----------
    path
        Where the bag is written.
    description
        What the output says of itself.
    source
        The bag whose messages are kept; None: there is none.

    Raises
    ------
    RecordingError
        If the source has the muscle's topics already.
    """

    def __init__(self, path: Path, description: OutputDescription, source: Path | None) -> None:
        """Open the bag, and add its topics."""
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.ROS2_JAZZY)
        originals, storage = ([], 'mcap') if source is None else list_bag_topics(source)
        added = added_topics(description)
        clashes = sorted(added.keys() & {each.topic for each in originals})
        if clashes:
            raise RecordingError(f'{source}: {clashes[0]} is in it already; it has been processed')
        self._writer = BagWriter(path, storage, description.facts)
        self._kept = {
            each.id: self._writer.add_topic(kept_topic(each, store)) for each in originals
        }
        self._added = {
            topic: self._writer.add_topic(new_topic(topic, kind, store))
            for topic, kind in added.items()
        }
        self._description, muscle = description, description.muscle
        self._answers = AnswerSerializer(
            store,
            muscle.band_names,
            description.coordinates,
            description.frame_id,
            description.bones,
        )
        self._joints = JointStateSerializer(store, description.coordinates, '')
        self._markers = MarkerSerializer(store, muscle, description.frame_id, POINTS_ON_ARC)
        self._limiter = RateLimiter(MARKER_RATE)

    def write(self, solved: SolvedChunk) -> None:
        """Append a chunk: each message, and after it the answers to its frames."""
        chunk = solved.chunk
        answers = self._serialize_answers(solved)
        if self._description.markers:
            self._append_markers(solved, answers)
        after = defaultdict(list)
        for k, record in enumerate(chunk.follows):
            after[record].append(k)
        times = chunk.times.tolist()
        if times and min(times) < 0:
            raise RecordingError(f'time {1e-9 * min(times):g} s: a bag has none before 0 s')
        write = self._writer.write
        for number, record in enumerate((None, *chunk.records), -1):
            if record is not None:
                connection, time, data, sent, sequence = record
                write(self._kept[connection.id], time, data, sent, sequence)
            for k in after[number]:
                for topic, data in answers[k]:
                    write(topic, times[k], data)

    def _serialize_answers(self, solved: SolvedChunk) -> list[list[tuple[int, bytes]]]:
        """Return, for each frame, the numbers of topics and the messages written to them."""
        chunk, states, description = solved.chunk, solved.states, self._description
        messages: dict[str, list[bytes]] = {}
        if description.angles_topic:
            messages[description.angles_topic] = self._joints.serialize(
                chunk.stamps, chunk.angles, chunk.speeds
            )
        answers = self._answers.serialize(
            chunk.stamps,
            states.lengths,
            solved.arms,
            solved.lengthening,
            states.wrap,
            states.moment_vectors,
            states.wrenches if description.bones else None,
        )
        for topic, each in answers.items():
            messages[f'/{description.muscle.name}/{topic}'] = each
        numbers = [self._added[topic] for topic in messages]
        frames = zip(*messages.values(), strict=True)
        return [list(zip(numbers, each, strict=True)) for each in frames]

    def _append_markers(
        self, solved: SolvedChunk, answers: Sequence[list[tuple[int, bytes]]]
    ) -> None:
        """Append the markers to the answers of those frames that get some."""
        number = self._added[f'/{self._description.muscle.name}/{MARKERS.name}']
        stamps, times = solved.chunk.stamps.tolist(), solved.chunk.times.tolist()
        chosen = [
            k
            for k, (stamp, time) in enumerate(zip(stamps, times, strict=True))
            if self._limiter.allows(1e-9 * stamp, 1e-9 * time)
        ]
        messages = self._markers.serialize(
            [solved.states[k] for k in chosen], [stamps[k] for k in chosen]
        )
        for k, message in zip(chosen, messages, strict=True):
            answers[k].append((number, message))

    def close(self) -> None:
        """Finish."""
        self._writer.finish()


def added_topics(description: OutputDescription) -> dict[str, str]:
    """Return the topics that a bag gets, and the types of their messages."""
    name = description.muscle.name
    added = {f'/{name}/{topic.name}': topic.type for topic in answer_topics(description.bones)}
    if description.angles_topic:
        added[description.angles_topic] = JOINT_STATE
    if description.markers:
        added[f'/{name}/{MARKERS.name}'] = MARKERS.type
    return added


def list_bag_topics(path: Path) -> tuple[list[Connection], str]:
    """Return the topics of a bag, and how it stores its messages: mcap or sqlite3."""
    with closing(open_bag(path)) as bag:
        return list(bag.connections), bag.storage
