# SPDX-License-Identifier: Apache-2.0
"""An annotated bag: what was recorded, and the muscle's topics among it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

from ..drawing.shapes import MARKER_RATE, POINTS_ON_ARC, RateLimiter
from ..errors import RecordingError
from ..recordings.bags.opening import open_bag
from ..recordings.bags.topics import JOINT_STATE
from .cdr import AnswerSerializer, JointStateSerializer
from .cdr_markers import MarkerSerializer
from .outputs import OutputDescription, SolvedChunk
from .topics import ANSWERS, MARKERS


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
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.ROS2_JAZZY)
        originals, plugin = [], StoragePlugin.MCAP
        if source is not None:
            originals = read_connections(source)
            if any('.db3' in each.name for each in bag_files(source)):
                plugin = StoragePlugin.SQLITE3
        added = added_topics(description)
        clashes = sorted(added.keys() & {each.topic for each in originals})
        if clashes:
            raise RecordingError(f'{source}: {clashes[0]} is in it already; it has been processed')
        self._writer = Writer(path, version=9, storage_plugin=plugin)
        for name, fact in description.facts.items():
            self._writer.set_custom_data(name, fact)
        self._writer.open()
        self._kept = self._keep_connections(originals)
        self._added = {
            topic: self._writer.add_connection(topic, kind, typestore=store)
            for topic, kind in added.items()
        }
        self._description, muscle = description, description.muscle
        self._answers = AnswerSerializer(
            store, muscle.band_names, description.coordinates, description.frame_id
        )
        self._joints = JointStateSerializer(store, description.coordinates, '')
        self._markers = MarkerSerializer(store, muscle, description.frame_id, POINTS_ON_ARC)
        self._limiter = RateLimiter(MARKER_RATE)

    def _keep_connections(self, originals: Sequence[Any]) -> dict[int, Any]:
        """Add the connections of the source; return them by their numbers in the source."""
        kept: dict[int, Any] = {}
        by_topic: dict[tuple[str, str], Any] = {}  # merged files may have several of one topic
        for each in originals:
            key = each.topic, each.msgtype
            if key not in by_topic:
                by_topic[key] = self._writer.add_connection(
                    each.topic,
                    each.msgtype,
                    msgdef=each.msgdef.data,
                    rihs01=each.digest or type_hash(each),
                    serialization_format=each.ext.serialization_format,
                    offered_qos_profiles=each.ext.offered_qos_profiles,
                )
            kept[each.id] = by_topic[key]
        return kept

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
                connection, time, data = record
                write(self._kept[connection.id], time, data)
            for k in after[number]:
                for connection, data in answers[k]:
                    write(connection, times[k], data)

    def _serialize_answers(self, solved: SolvedChunk) -> list[list[tuple[Any, bytes]]]:
        """Return, for each frame, the connections and the messages written to them."""
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
        )
        for topic, each in answers.items():
            messages[f'/{description.muscle.name}/{topic}'] = each
        connections = [self._added[topic] for topic in messages]
        frames = zip(*messages.values(), strict=True)
        return [list(zip(connections, each, strict=True)) for each in frames]

    def _append_markers(
        self, solved: SolvedChunk, answers: Sequence[list[tuple[Any, bytes]]]
    ) -> None:
        """Append the markers to the answers of those frames that get some."""
        connection = self._added[f'/{self._description.muscle.name}/{MARKERS.name}']
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
            answers[k].append((connection, message))

    def close(self) -> None:
        """Finish."""
        file = getattr(self._writer.storage, 'bio', None)  # of an MCAP
        try:
            self._writer.close()
        except OSError:
            if file is not None:
                with suppress(OSError):  # Python would say it later, when it drops the file
                    file.close()
            raise


def added_topics(description: OutputDescription) -> dict[str, str]:
    """Return the topics that a bag gets, and the types of their messages."""
    name = description.muscle.name
    added = {f'/{name}/{topic.name}': topic.type for topic in ANSWERS}
    if description.angles_topic:
        added[description.angles_topic] = JOINT_STATE
    if description.markers:
        added[f'/{name}/{MARKERS.name}'] = MARKERS.type
    return added


def read_connections(bag: Path) -> list[Any]:
    """Return the connections of a bag: its topics, with types and quality of service."""
    with closing(open_bag(bag)) as reader:
        return list(reader.connections)


def type_hash(connection: Any) -> str:
    """Return the hash of a message type, for a bag without it; empty for an unknown type."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    if connection.msgtype not in store.fielddefs and not connection.msgdef.data:
        return ''
    if connection.msgtype not in store.fielddefs:
        store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
    return str(store.hash_rihs01(connection.msgtype))


def bag_files(bag: Path) -> list[Path]:
    """Return the files of a bag."""
    return list(bag.iterdir()) if bag.is_dir() else [bag]
