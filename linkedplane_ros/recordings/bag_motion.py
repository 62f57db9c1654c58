"""The motion in a ROS 2 bag: its joint states, or the poses of bones, message by message."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..errors import RecordingError
from ..joints.conventions import JointConvention
from ..joints.joint_state import JointMap, JointMemory, Rejected
from .bags import JOINT_STATE, deserialized, opened
from .frames import POSE_TYPES, TF_TYPE, Bones, PoseMemory
from .motion import ROWS, Chunk, Frame, Refused

USUAL = '/joint_states'
BYTES = 2**24  # of a bag's messages, held at a time


class Batch(NamedTuple):
    """Some messages of a bag, one after the other."""

    records: list[Any]
    """connection, time (ns), bytes"""
    share: float
    """Of the recording, read so far, 0 to 1."""
    last: bool = False


class Taker(Protocol):
    """Makes frames of a bag's messages."""

    @property
    def facts(self) -> Mapping[str, str]:
        """What is taken."""

    def wants(self, topic: str, kind: str) -> bool:
        """Return whether a topic's messages are to be taken."""

    def take(self, message: Any, topic: str, time: int) -> Iterator[Frame]:
        """Yield the frames that a message, recorded at a time (ns), completes.

        Rejected if it is no good.
        """

    def rest(self) -> Iterator[Frame]:
        """Yield the frames that only the end of the recording completes."""

    def unused(self) -> Iterator[tuple[str, int, str]]:
        """Yield why, how many and where, of what gave no frame and was not rejected."""


@dataclass
class JointTaker:
    """Joint states, taken as the node takes them."""

    topic: str
    memory: JointMemory

    @property
    def facts(self) -> Mapping[str, str]:
        """Where the angles come from."""
        velocities = 'recorded, where the recording has them'
        return {'topic': self.topic, **self.memory.joints.facts, 'velocities': velocities}

    def wants(self, topic: str, kind: str) -> bool:
        """Return whether these are the joint states chosen."""
        return kind == JOINT_STATE and topic == self.topic

    def take(self, message: Any, topic: str, time: int) -> Iterator[Frame]:
        """Yield the one frame of a message."""
        angles, speeds, _ = self.memory.take(
            message.name, message.position.tolist(), message.velocity.tolist()
        )
        stamp = message.header.stamp
        yield Frame(stamp.sec * 10**9 + stamp.nanosec, time, angles, speeds)

    def rest(self) -> Iterator[Frame]:
        """Yield nothing: no message waits for another."""
        yield from ()

    def unused(self) -> Iterator[tuple[str, int, str]]:
        """Yield nothing: each message has its frame, or was rejected."""
        yield from ()


class BagMotion:
    """The frames of a bag, and all its messages."""

    def __init__(self, path: Path, taker: Taker) -> None:
        """Look into the bag; RecordingError if it is no good."""
        self.path: Path = path
        self.refused: Refused = Refused()
        self.taker = taker
        self.facts: Mapping[str, str] = taker.facts
        self.keeps_records = True
        with closing(opened(path)) as reader:
            self.start: int = reader.start_time
            self.count: int = reader.message_count

    @staticmethod
    def of_joints(path: Path, joints: JointMap, topic: str | None) -> BagMotion:
        """Return a bag's joint states: on the topic chosen, the usual one, or the only one."""
        with closing(opened(path)) as reader:
            found = {each.topic for each in reader.connections if each.msgtype == JOINT_STATE}
            if topic is None and USUAL in found:
                topic = USUAL
            if topic is None and len(found) > 1:
                raise RecordingError(
                    f'{path}: joint states on {", ".join(sorted(found))}; choose one with --topic'
                )
            if not found or (topic is not None and topic not in found):
                kinds = ', '.join(sorted({f'{c.topic} ({c.msgtype})' for c in reader.connections}))
                wanted = f'no {JOINT_STATE}' + (f' on {topic}' if topic else '')
                raise RecordingError(f'{path}: {wanted} in it, but {kinds or "nothing"}')
        return BagMotion(path, JointTaker(topic or found.pop(), JointMemory(joints)))

    @staticmethod
    def of_poses(
        path: Path, bones: Bones, convention: JointConvention, side: str = 'right'
    ) -> BagMotion:
        """Return the motion of the humerus against another bone."""
        with closing(opened(path)) as reader:
            topics = {each.topic: each.msgtype for each in reader.connections}
            if TF_TYPE not in topics.values():
                for name in (bones.humerus, bones.base):
                    if topics.get(name) not in POSE_TYPES:
                        held = ', '.join(sorted(f'{t} ({k})' for t, k in topics.items()))
                        raise RecordingError(
                            f'{path}: {name} is neither a topic of {" or ".join(POSE_TYPES)} '
                            f'nor, for want of /tf, a frame; in it: {held or "nothing"}'
                        )
        return BagMotion(path, PoseMemory(bones, convention, side))

    def records(self) -> Iterator[Batch]:
        """Yield all messages, some at a time."""
        with closing(opened(self.path)) as reader:
            yield from self._records(reader)

    def _records(self, reader: Any) -> Iterator[Batch]:
        messages = reader.messages()
        read = 0
        while True:
            records: list[Any] = []
            held = 0  # bytes
            try:
                while len(records) < ROWS and held < BYTES:
                    connection, time, data = next(messages)
                    records.append((connection, time, bytes(data)))
                    held += len(data)
            except StopIteration:
                yield Batch(records, 1.0, last=True)
                return
            except Exception as error:  # a broken file breaks in many ways
                raise RecordingError(f'{self.path}: damaged: {error}') from None
            read += len(records)
            yield Batch(records, read / max(self.count, read))

    def chunks(self) -> Iterator[Chunk]:
        """Yield the frames, and all messages of the bag between them."""
        number = 0
        with closing(opened(self.path)) as reader:
            for batch in self._records(reader):
                frames: list[Frame] = []
                follows: list[int] = []
                for k, (connection, time, data) in enumerate(batch.records):
                    if not self.taker.wants(connection.topic, connection.msgtype):
                        continue
                    number += 1
                    for frame in self._frames(reader, connection, time, data, number):
                        frames.append(frame)
                        follows.append(k)
                if batch.last:
                    rest = list(self._answered(self.taker.rest(), self._where(number, 0)))
                    frames += rest
                    follows += [len(batch.records) - 1] * len(rest)
                yield self._chunk(frames, follows, batch)
        for reason, count, where in self.taker.unused():
            self.refused.add(reason, where, count)

    def _where(self, number: int, time: int) -> str:
        return f'message {number}' + (f', {1e-9 * (time - self.start):.2f} s' if time else '')

    def _frames(
        self, reader: Any, connection: Any, time: int, data: bytes, number: int
    ) -> Iterator[Frame]:
        """Yield the frames of a message; count it as refused if it is no good."""
        try:
            message = deserialized(reader, data, connection.msgtype)
        except Exception as error:
            raise RecordingError(f'{self.path}: message {number} is damaged: {error}') from None
        taken = self.taker.take(message, connection.topic, time)
        yield from self._answered(taken, self._where(number, time))

    def _answered(self, frames: Iterator[Frame], where: str) -> Iterator[Frame]:
        try:
            yield from frames
        except Rejected as error:
            self.refused.add(error.reason, f'{where}: {error}')

    def _chunk(self, frames: list[Frame], follows: list[int], batch: Batch) -> Chunk:
        unknown = (np.nan, np.nan, np.nan)
        k = len(frames)
        return Chunk(
            stamps=np.array([each.stamp for each in frames], dtype=np.int64),
            angles=np.array([each.angles for each in frames]).reshape(k, 3),
            speeds=np.array([each.speeds or unknown for each in frames]).reshape(k, 3),
            times=np.array([each.time for each in frames], dtype=np.int64),
            share=batch.share,
            records=batch.records if self.keeps_records else (),
            follows=follows,
        )
