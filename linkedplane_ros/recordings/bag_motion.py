# SPDX-License-Identifier: Apache-2.0
"""The motion in a ROS 2 bag: its joint states, or the poses of bones, message by message."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..errors import RecordingError
from ..joints.conventions import JointConvention
from ..joints.joint_state import FULL_CIRCLE, JointMap, JointMemory, OtherJoints
from .bags.bag import Bag
from .bags.connections import Connection, RecordedMessage
from .bags.messages import DamagedMessage
from .bags.opening import open_bag
from .bags.topics import JOINT_STATE, choose_joint_topic, read_joint_names, read_topics
from .bone_frames import BoneFrames
from .frame_readers import FrameReader, JointFrameReader
from .motion import ROWS, Chunk, Frame, Place, Refusals, Refused
from .poses import POSE_TYPES, TF_TYPE, PoseFrameReader
from .stamps import find_offset, find_unstamped, read_header_stamp
from .stretches import TimeWatch, format_seconds
from .units import decide_unit, name_words

BATCH_BYTES = 2**24  # of a bag's messages, held at a time


class Batch(NamedTuple):
    """Some messages of a bag, one after the other."""

    records: list[RecordedMessage]
    share: float
    """Of the recording, read so far, 0 to 1."""
    last: bool = False


class BagMotion:
    """The motion in a bag, and all the bag's messages.

    Parameters
    ----------
    path
        The bag's folder, or one of its files.
    frame_reader
        What makes frames of its messages.

    Raises
    ------
    RecordingError
        If the bag cannot be read.
    """

    def __init__(self, path: Path, frame_reader: FrameReader) -> None:
        """Read what the bag says about itself; its messages are read by `chunks`."""
        self.path: Path = path
        self.refused: Refusals = Refusals()
        self.frame_reader = frame_reader
        self.others = 0
        """How many messages were of other joints alone."""
        self.first_other = ''
        self.unit, self.met = frame_reader.unit, frame_reader.met
        self.facts: Mapping[str, str] = {
            **frame_reader.facts,
            'stamps': 'of the headers; where these are 0, not filled in, the recorded times, '
            'on the clock of the headers',
        }
        self.keeps_records = self.wants_speeds = True
        with closing(open_bag(path)) as bag:
            self.start: int = bag.start_time
            self.count: int = bag.message_count
            if bag.faults:
                self.facts = {**self.facts, 'damage': '; '.join(bag.faults)}

    @staticmethod
    def from_joint_states(
        path: Path, joints: JointMap, topic: str | None, degrees: bool | None = None
    ) -> BagMotion:
        """Return the motion in a bag's joint states.

        Parameters
        ----------
        path
            The bag.
        joints
            Which joints are the coordinates.
        topic
            The topic of the joint states; None: the one that has the joints.
        degrees
            Whether they are in degrees; None: as the joints' names say, else rad.

        Raises
        ------
        RecordingError
            If the bag has no such topic, or several of which none was chosen; or if the joints'
            names contradict `degrees`.
        """
        with closing(open_bag(path)) as bag:
            topics = read_topics(bag)
            held = {name for name, kind in topics if kind == JOINT_STATE}
            unclear = len(held) > 1 if topic is None else topic not in held
            names = read_joint_names(bag) if unclear else None
            others = {each.topic for each in bag.connections if each.kind == JOINT_STATE}
        chosen = choose_joint_topic(path, topics, topic, '--topic {}', names, joints.needed)
        turning = [name for name in joints.needed if name not in joints.sliding]
        words = name_words(path, turning, alone=degrees is None, kind='joint')
        unit = decide_unit(path, degrees, words, 'REP 103')
        motion = BagMotion(path, JointFrameReader(chosen, JointMemory(joints), unit))
        others -= {chosen}
        if topic is None and others:
            passed_over = ', '.join(sorted(others))
            motion.refused.notes.append(f'joint states of {chosen}, not of {passed_over} (--topic)')
        return motion

    @staticmethod
    def from_poses(
        path: Path, bones: BoneFrames, convention: JointConvention, side: str = 'right'
    ) -> BagMotion:
        """Return the motion of the humerus against another bone, from the poses in a bag.

        Parameters
        ----------
        path
            The bag.
        bones
            Which frames are the bones.
        convention
            What the angles mean.
        side
            'right' or 'left': which shoulder the frames are of.

        Raises
        ------
        RecordingError
            If the bag has neither poses of the frames nor /tf.
        """
        with closing(open_bag(path)) as bag:
            topics = {(each.topic, each.kind) for each in bag.connections}
            if TF_TYPE not in {kind for _, kind in topics}:
                held_poses = {topic for topic, kind in topics if kind in POSE_TYPES}
                names = reversed(list(bones.names.values()))
                missing = [each for each in names if each not in held_poses]
                if missing:
                    held = ', '.join(sorted(f'{t} ({k})' for t, k in topics))
                    raise RecordingError(
                        f'{path}: {missing[0]} is not a topic of {" or ".join(POSE_TYPES)}, and '
                        f'there is no /tf with frames; in it: {held or "nothing"}'
                    )
        return BagMotion(path, PoseFrameReader(bones, convention, side))

    def batches(self) -> Iterator[Batch]:
        """Yield all messages of the bag, some at a time."""
        with closing(open_bag(self.path)) as bag:
            yield from self._read_batches(bag)

    def _read_batches(self, bag: Bag) -> Iterator[Batch]:
        messages = bag.messages()
        read = 0
        while True:
            records: list[RecordedMessage] = []
            held = 0  # bytes
            while len(records) < ROWS and held < BATCH_BYTES:
                message = next(messages, None)
                if message is None:
                    yield Batch(records, 1.0, last=True)
                    return
                records.append(message)
                held += len(message.data)
            read += len(records)
            yield Batch(records, read / max(self.count, read))

    def chunks(self) -> Iterator[Chunk]:
        """Yield the frames, and all messages of the bag between them."""
        watch = TimeWatch(self.refused, 'message')
        number = 0
        with closing(open_bag(self.path)) as bag:
            for batch, instead in self._find_stamps(bag):
                frames: list[Frame] = []
                follows: list[int] = []
                for k, (connection, time, data, *_) in enumerate(batch.records):
                    if self.frame_reader.accepts(connection.topic, connection.kind):
                        number += 1
                        place = Place(number, time, instead.get(k))
                        made = self._frames(bag, connection, data, place)
                        frames += made
                        follows += [k] * len(made)
                if batch.last:
                    rest = self._keep_usable(self.frame_reader.last_frames())
                    frames += rest
                    follows += [len(batch.records) - 1] * len(rest)
                self.refused.used += len(frames)
                if self.met.largest <= FULL_CIRCLE:  # else it is refused, with its whole range
                    chunk = self._chunk(frames, follows, batch)
                    watch.check(chunk.stamps, [each.place.number for each in frames])
                    yield chunk
            self._count_losses(bag)
        self.met.check_circle(self.path)
        self.refused.notes += [f'warning: {line}' for line in self.frame_reader.notes]
        for reason, count, where in self.frame_reader.unused_messages():
            self.refused.add(reason, where, count)
        if number == self.others and self.others:
            self.refused.add('no_joint', self.first_other, self.others)
        elif self.others:
            of = f'{self.others:,} message{"s" * (self.others > 1)} of other joints'
            self.refused.notes.append(f'{of} passed over, first at {self.first_other}')

    def _find_stamps(self, bag: Bag) -> Iterator[tuple[Batch, Mapping[int, int]]]:
        """Yield the batches, each with what counts for its messages without a stamp, by index."""
        batches = self._read_batches(bag)
        offset: int | None = None
        ahead: list[tuple[Batch, list[int], list[int]]] = []
        while ahead or (batch := next(batches, None)):
            if not ahead:
                assert batch is not None
                ahead.append((batch, *self._read_stamps(batch)))
            batch, places, stamps = ahead.pop(0)
            following = 0
            if stamps and stamps[-1] == 0 and (after := next(batches, None)):
                ahead.append((after, *self._read_stamps(after)))
                following = next(filter(None, ahead[0][2]), 0)
            unstamped = {places[k] for k in find_unstamped(stamps, following)}
            instead: dict[int, int] = {}
            for k, stamp in zip(places, stamps, strict=True):
                time = batch.records[k].time
                if k not in unstamped:
                    offset = find_offset(stamp, time)
                    continue
                if offset is None:
                    offset = self._find_first_offset()
                instead[k] = time + offset
                self._note_unstamped(time, offset)
            yield batch, instead

    def _find_first_offset(self) -> int:
        """Return what takes recorded times to the clock of the first stamp, ns; 0 without any."""
        with closing(open_bag(self.path)) as bag:
            accepts = self.frame_reader.accepts
            chosen = [each for each in bag.connections if accepts(each.topic, each.kind)]
            for connection, time, data, *_ in bag.messages(chosen):
                if stamp := read_header_stamp(connection.topic, connection.kind, data):
                    return find_offset(stamp, time)
        return 0

    def _note_unstamped(self, time: int, offset: int) -> None:
        where = f'{1e-9 * (time - self.start):.2f} s after the start'
        line = f'a header without a stamp (0), {where}: the recorded time counts'
        if offset:
            line += f', shifted by {format_seconds(offset)} s to the clock of the other stamps'
        self.refused.note('shifted' if offset else 'unstamped', line)

    def _read_stamps(self, batch: Batch) -> tuple[list[int], list[int]]:
        """Return the indices and the stamps of the messages that make frames."""
        stamps = {
            k: stamp
            for k, (connection, _, data, *_) in enumerate(batch.records)
            if self.frame_reader.accepts(connection.topic, connection.kind)
            and (stamp := read_header_stamp(connection.topic, connection.kind, data)) is not None
        }
        return list(stamps), list(stamps.values())

    def _count_losses(self, bag: Bag) -> None:
        """Count what the bag should have of the frames' messages; note what else is missing."""
        accepts = self.frame_reader.accepts
        read = {each.topic for each in bag.connections if accepts(each.topic, each.kind)}
        bag.check()
        for fault in bag.faults:
            self.refused.note(fault, f'{self.path}: {fault}')
        for loss in bag.losses():
            if loss.topic in read:
                self.refused.add(loss.reason, loss.where, loss.number)
            else:
                self.refused.notes.append(f'messages not read: {loss.number:,}: {loss.where}')
        self.refused.notes += bag.surpluses()

    def _frames(self, bag: Bag, connection: Connection, data: bytes, place: Place) -> list[Frame]:
        """Return the frames of a message; count what cannot be used."""
        try:
            message = bag.read_message(connection, data)
        except DamagedMessage as error:
            self.refused.add('damaged', f'{self._describe_place(place)}: {error}')
            return []
        try:
            return self._keep_usable(
                self.frame_reader.read_frames(message, connection.topic, place)
            )
        except OtherJoints as error:
            self.others += 1
            self.first_other = self.first_other or f'{self._describe_place(place)}: {error}'
            return []

    def _keep_usable(self, made: Iterator[Frame | Refused]) -> list[Frame]:
        """Return the frames; count those that are refused, with the place of their message."""
        frames = []
        for each in made:
            if isinstance(each, Frame):
                frames.append(each)
            else:
                where = f'{self._describe_place(each.place)}: {each.text}'
                self.refused.add(each.reason, where)
        return frames

    def _describe_place(self, place: Place) -> str:
        return f'message {place.number}, {1e-9 * (place.time - self.start):.2f} s'

    def _chunk(self, frames: list[Frame], follows: list[int], batch: Batch) -> Chunk:
        k, width = len(frames), self.frame_reader.width
        unknown = (np.nan,) * width
        poses = [each.poses for each in frames if each.poses is not None]
        return Chunk(
            stamps=np.array([each.stamp for each in frames], dtype=np.int64),
            angles=np.array([each.angles for each in frames]).reshape(k, width),
            speeds=np.array([each.speeds or unknown for each in frames]).reshape(k, width),
            times=np.array([each.place.time for each in frames], dtype=np.int64),
            share=batch.share,
            records=batch.records if self.keeps_records else (),
            follows=follows,
            poses=np.array(poses).reshape(k, -1, 3, 4) if len(poses) == k > 0 else None,
        )
