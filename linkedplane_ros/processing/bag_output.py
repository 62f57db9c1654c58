"""An annotated bag: what was recorded, and the muscle's topics among it."""

from __future__ import annotations

from collections import defaultdict
from contextlib import closing
from pathlib import Path
from typing import Any

from ..drawing.shapes import MARKER_RATE, POINTS_ON_ARC, RateLimiter
from ..errors import RecordingError
from ..recordings.bags import JOINT_STATE, open_bag
from .cdr import JointStates, SerializedAnswers
from .cdr_markers import SerializedMarkers
from .outputs import Described, Solved
from .topics import ANSWERS, MARKERS


class BagOutput:
    """A bag's own messages, byte for byte, and the muscle's topics among them."""

    def __init__(self, path: Path, described: Described, source: Path | None) -> None:
        """Open the bag; `source` is the bag whose messages are kept."""
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.ROS2_JAZZY)
        muscle, plugin = described.muscle, StoragePlugin.MCAP
        originals: list[Any] = []
        if source is not None:
            with closing(open_bag(source)) as reader:
                originals = list(reader.connections)
                if any('.db3' in each.name for each in files_of(source)):
                    plugin = StoragePlugin.SQLITE3
        added = {f'/{muscle.name}/{topic.name}': topic.type for topic in ANSWERS}
        if described.angles_topic:
            added[described.angles_topic] = JOINT_STATE
        if described.markers:
            added[f'/{muscle.name}/{MARKERS.name}'] = MARKERS.type
        for topic in added.keys() & {each.topic for each in originals}:
            raise RecordingError(f'{source}: {topic} is in it already; it has been processed')
        self._writer = Writer(path, version=9, storage_plugin=plugin)
        for name, fact in described.facts.items():
            self._writer.set_custom_data(name, fact)
        self._writer.open()
        self._kept: dict[int, Any] = {}
        same: dict[tuple[str, str], Any] = {}  # merged files may have several of one topic
        for each in originals:
            if (each.topic, each.msgtype) not in same:
                same[each.topic, each.msgtype] = self._writer.add_connection(
                    each.topic,
                    each.msgtype,
                    msgdef=each.msgdef.data,
                    rihs01=each.digest or digest(each),
                    serialization_format=each.ext.serialization_format,
                    offered_qos_profiles=each.ext.offered_qos_profiles,
                )
            self._kept[each.id] = same[each.topic, each.msgtype]
        self._added = {
            topic: self._writer.add_connection(topic, kind, typestore=store)
            for topic, kind in added.items()
        }
        self._described = described
        self._answers = SerializedAnswers(
            store, muscle.band_names, described.coordinates, described.frame_id
        )
        self._joints = JointStates(store, described.coordinates, '')
        self._markers = SerializedMarkers(store, muscle, described.frame_id, POINTS_ON_ARC)
        self._pace = RateLimiter(MARKER_RATE)

    def write(self, solved: Solved) -> None:
        """Append a chunk: each message, and behind it the answers to its frames."""
        chunk = solved.chunk
        frames = self._frames(solved)
        behind = defaultdict(list)
        for k, record in enumerate(chunk.follows):
            behind[record].append(k)
        times = chunk.times.tolist()
        if times and min(times) < 0:
            raise RecordingError(f'time {1e-9 * min(times):g} s: a bag has none before 0 s')
        write = self._writer.write
        for number, record in enumerate((None, *chunk.records), -1):
            if record is not None:
                connection, time, data = record
                write(self._kept[connection.id], time, data)
            for k in behind[number]:
                for connection, data in frames[k]:
                    write(connection, times[k], data)

    def _frames(self, solved: Solved) -> list[list[tuple[Any, bytes]]]:
        """Return, for each frame, its messages and the topics that they go to."""
        chunk, states, described = solved.chunk, solved.states, self._described
        made = {
            f'/{described.muscle.name}/{topic}': messages
            for topic, messages in self._answers.of(
                chunk.stamps,
                states.lengths,
                solved.arms,
                solved.lengthening,
                states.wrap,
                states.moment_vectors,
            ).items()
        }
        if described.angles_topic:
            angles = self._joints.filled(chunk.stamps, chunk.angles, chunk.speeds)
            made = {described.angles_topic: angles} | made
        topics = [self._added[topic] for topic in made]
        frames = [list(zip(topics, each, strict=True)) for each in zip(*made.values(), strict=True)]
        if described.markers:
            topic = self._added[f'/{described.muscle.name}/{MARKERS.name}']
            stamps, times = chunk.stamps.tolist(), chunk.times.tolist()
            due = [
                k
                for k, (stamp, time) in enumerate(zip(stamps, times, strict=True))
                if self._pace.allows(1e-9 * stamp, 1e-9 * time)
            ]
            shown = self._markers.of([states[k] for k in due], [stamps[k] for k in due])
            for k, message in zip(due, shown, strict=True):
                frames[k].append((topic, message))
        return frames

    def close(self) -> None:
        """Finish."""
        self._writer.close()


def digest(connection: Any) -> str:
    """Return the hash of a message type, for a bag that does not tell it; empty if not known."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    if connection.msgtype not in store.fielddefs and not connection.msgdef.data:
        return ''
    if connection.msgtype not in store.fielddefs:
        store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
    made: str = store.hash_rihs01(connection.msgtype)
    return made


def files_of(bag: Path) -> list[Path]:
    """Return the files of a bag."""
    return list(bag.iterdir()) if bag.is_dir() else [bag]
