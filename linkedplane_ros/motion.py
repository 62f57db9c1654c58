"""Recorded motion as chunks of joint angles: from a ROS 2 bag, message by message, or a table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from .conventions import JointConvention
from .frames import POSE_TYPES, TF_TYPE, Bones, PoseMemory
from .joint_input import FULL_CIRCLE, JointMap, JointMemory, Rejected, Three
from .recordings import JOINT_STATE, RecordingError, deserialized, opened
from .tables import Table, choose, differentiated, lowpassed, resampled

Floats = npt.NDArray[np.float64]
Stamps = npt.NDArray[np.int64]

USUAL = '/joint_states'
LONGEST = 2.0**31  # s: a stamp holds no more
BYTES = 2**24  # of a bag's messages, held at a time
ROWS = 5000  # frames that are worked on at a time


@dataclass
class Refused:
    """What could not be used of a recording: how many by reason, and where first."""

    counts: Counter[str] = field(default_factory=Counter)
    first: dict[str, str] = field(default_factory=dict)

    def add(self, reason: str, where: str, count: int = 1) -> None:
        """Count what was met at a place."""
        self.counts[reason] += count
        self.first.setdefault(reason, where)


@dataclass(frozen=True, eq=False)
class Chunk:
    """Some frames of a motion, in their order, and what they stood among."""

    stamps: Stamps
    """(k,) ns."""
    angles: Floats
    """(k, 3) rad."""
    speeds: Floats
    """(k, 3) rad/s; NaN where not known."""
    records: Sequence[Any] = ()
    """A bag's own messages, (connection, time, bytes), all of them."""
    answered: Sequence[int] = ()
    """(k,) for each frame the record that it came with."""

    def of(self, good: npt.NDArray[np.bool_]) -> Chunk:
        """Return the chunk with some of its frames alone; the records stay."""
        kept = [record for record, keep in zip(self.answered, good, strict=False) if keep]
        return Chunk(self.stamps[good], self.angles[good], self.speeds[good], self.records, kept)


class Motion(Protocol):
    """A recording of joint angles."""

    path: Path
    refused: Refused

    keeps_records: bool
    """Whether a bag's own messages are wanted with the frames."""

    def chunks(self) -> Iterator[Chunk]:
        """Yield the frames."""


class Taker(Protocol):
    """Makes frames of a bag's messages."""

    def wants(self, topic: str, kind: str) -> bool:
        """Return whether a topic's messages are to be taken."""

    def take(self, message: Any, topic: str) -> Iterator[tuple[int, Three, Three | None]]:
        """Yield stamp (ns), angles (rad) and speeds (rad/s); Rejected if it is no good."""


@dataclass
class JointTaker:
    """Joint states, taken as the node takes them."""

    topic: str
    memory: JointMemory

    def wants(self, topic: str, kind: str) -> bool:
        """Return whether these are the joint states chosen."""
        return kind == JOINT_STATE and topic == self.topic

    def take(self, message: Any, topic: str) -> Iterator[tuple[int, Three, Three | None]]:
        """Yield the one frame of a message."""
        angles, speeds, _ = self.memory.take(
            message.name, message.position.tolist(), message.velocity.tolist()
        )
        stamp = message.header.stamp
        yield stamp.sec * 10**9 + stamp.nanosec, angles, speeds


class BagMotion:
    """The frames of a bag, and all its messages."""

    def __init__(self, path: Path, taker: Taker) -> None:
        """Look into the bag; RecordingError if it is no good."""
        self.path: Path = path
        self.refused: Refused = Refused()
        self.taker = taker
        self.keeps_records = True
        with closing(opened(path)) as reader:
            self.start: int = reader.start_time

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

    def chunks(self) -> Iterator[Chunk]:
        """Yield the frames, and all messages of the bag between them."""
        with closing(opened(self.path)) as reader:
            messages = reader.messages()
            number = 0
            ended = False
            while not ended:
                records: list[Any] = []
                frames: list[tuple[int, Three, Three | None]] = []
                answered: list[int] = []
                held = 0  # bytes
                while len(records) < ROWS and len(frames) < ROWS and held < BYTES:
                    try:
                        connection, time, data = next(messages)
                    except StopIteration:
                        ended = True
                        break
                    except Exception as error:  # a broken file breaks in many ways
                        raise RecordingError(f'{self.path}: damaged: {error}') from None
                    if self.keeps_records:
                        records.append((connection, time, bytes(data)))
                        held += len(data)
                    if not self.taker.wants(connection.topic, connection.msgtype):
                        continue
                    number += 1
                    try:
                        message = deserialized(reader, data, connection.msgtype)
                    except Exception as error:
                        raise RecordingError(
                            f'{self.path}: message {number} is damaged: {error}'
                        ) from None
                    try:
                        for frame in self.taker.take(message, connection.topic):
                            frames.append(frame)
                            answered.append(len(records) - 1)
                    except Rejected as error:
                        where = f'message {number}, {1e-9 * (time - self.start):.2f} s: {error}'
                        self.refused.add(error.reason, where)
                unknown = (np.nan, np.nan, np.nan)
                yield Chunk(
                    np.array([stamp for stamp, _, _ in frames], dtype=np.int64),
                    np.array([angles for _, angles, _ in frames]).reshape(len(frames), 3),
                    np.array([speeds or unknown for _, _, speeds in frames]).reshape(
                        len(frames), 3
                    ),
                    records,
                    answered,
                )


class TableMotion:
    """Three columns of a table; their velocities are differences in time."""

    def __init__(self, path: Path, joints: JointMap, degrees: bool | None) -> None:
        """Read the header; RecordingError if it is no good, or lacks a column."""
        self.path: Path = path
        self.refused: Refused = Refused()
        self.joints = joints
        self.table = Table.open(path)
        self.keeps_records = False
        self.columns, unit = choose_with_unit(self.table, joints.names)
        stated = self.table.in_degrees if unit is None else unit
        in_degrees = stated if degrees is None else degrees
        self.scale = np.pi / 180.0 if in_degrees else 1.0

    def chunks(self) -> Iterator[Chunk]:
        """Yield the rows that can be used."""
        times, angles = np.empty(0), np.empty((0, 3))
        first = row = 0  # the first of the held rows that is still to be given
        for new_times, values in self.table.chunks(self.columns, ROWS):
            values = values * self.scale
            good = self._usable(new_times, values, row)
            row += len(new_times)
            times = np.concatenate((times, new_times[good]))
            angles = np.concatenate(
                (angles, (values * self.joints.signs + self.joints.offsets)[good])
            )
            # a difference takes both neighbours: the last row waits for the next chunk
            if len(times) > 1 + first:
                yield self._chunk(times, angles, slice(first, -1))
                times, angles, first = times[-2:], angles[-2:], 1
        if len(times) > first:
            yield self._chunk(times, angles, slice(first, None))

    def _chunk(self, times: Floats, angles: Floats, part: slice) -> Chunk:
        with np.errstate(divide='ignore', invalid='ignore'):  # times that stand still
            speeds = differentiated(times, angles)
        speeds[~np.isfinite(speeds).all(axis=1)] = np.nan
        try:
            return Chunk(in_nanoseconds(times[part]), angles[part], speeds[part])
        except ValueError as error:
            raise RecordingError(f'{self.path}: {error}') from None

    def _usable(self, times: Floats, angles: Floats, row: int) -> npt.NDArray[np.bool_]:
        """Return which rows are angles; the others are refused, as the node does."""
        finite = np.isfinite(angles).all(axis=1)
        small = ~(np.abs(angles) > FULL_CIRCLE).any(axis=1)
        for reason, bad, hint in (
            ('not_finite', ~finite, 'a finite angle expected'),
            ('degrees', finite & ~small, 'degrees? radians expected (--degrees)'),
        ):
            if bad.any():
                k = int(np.argmax(bad))
                where = f'row {row + k + 1}, {times[k]:.2f} s: {angles[k].tolist()}: {hint}'
                self.refused.add(reason, where, int(bad.sum()))
        return np.asarray(finite & small)


@dataclass
class Smoothed:
    """A motion filtered and brought to a constant rate; it holds the whole of its angles."""

    motion: Motion
    rate: float | None
    """Hz; None: as recorded, which has to be constant to be filtered."""
    cutoff: float | None
    """Hz."""
    keeps_records: bool = False

    def __post_init__(self) -> None:
        """Stand for the motion."""
        self.path, self.refused = self.motion.path, self.motion.refused

    def chunks(self) -> Iterator[Chunk]:
        """Yield the frames at their new times, with velocities by differences."""
        self.motion.keeps_records = False
        parts = [(c.stamps, c.angles) for c in self.motion.chunks() if len(c.stamps)]
        if not parts:
            return
        stamps = np.concatenate([stamps for stamps, _ in parts])
        angles = np.concatenate([angles for _, angles in parts])
        times = 1e-9 * (stamps - stamps[0])
        try:
            rate = self.rate or steady_rate(times)
            # as many samples as were recorded are filtered, then brought to the rate asked for
            if self.cutoff is not None:
                own = (len(times) - 1) / times[-1] if len(times) > 1 and times[-1] > 0.0 else rate
                times, angles = resampled(times, angles, own)
                angles = lowpassed(angles, own, self.cutoff)
            if self.rate is not None:
                times, angles = resampled(times, angles, rate)
        except ValueError as error:
            raise RecordingError(f'{self.path}: {error}') from None
        speeds = differentiated(times, angles)
        new = stamps[0] + in_nanoseconds(times)
        for k in range(0, len(new), ROWS):
            part = slice(k, k + ROWS)
            yield Chunk(new[part], angles[part], speeds[part])


def steady_rate(times: Floats) -> float:
    """Return the rate, Hz, of evenly spaced times (m,), s; ValueError for others."""
    steps = np.diff(times)
    if len(steps) and 0.0 < steps.min() and steps.max() < 1.5 * np.median(steps):
        return float(1.0 / np.median(steps))
    raise ValueError('the recording is not evenly spaced in time; give a --rate, too')


def in_nanoseconds(times: Floats) -> Stamps:
    """Return times (m,), s, as ns; ValueError for times that cannot be seconds."""
    if len(times) and np.abs(times).max() > LONGEST:
        raise ValueError(f'time {times[np.abs(times).argmax()]:g}: more than {LONGEST:g} s; ms?')
    return np.asarray(np.rint(times * 1e9), dtype=np.int64)


def choose_with_unit(table: Table, names: Sequence[str]) -> tuple[tuple[str, ...], bool | None]:
    """Return the columns of three joints; and whether they are in degrees, if their names say so.

    A column may carry its unit behind the joint's name: `_rad` or `_deg`.
    """
    for ending, in_degrees in (('_rad', False), ('_deg', True)):
        wanted = [name + ending for name in names]
        if set(wanted) <= set(table.columns):
            return tuple(wanted), in_degrees
    try:
        return choose(table.columns, names), None
    except RecordingError as error:
        raise RecordingError(f'{table.path}: {error}') from None
