# SPDX-License-Identifier: Apache-2.0
"""Read a processed recording back, for plots: CSV, Parquet, or an annotated bag."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ..drawing.processed import ProcessedRecording
from ..errors import RecordingError
from ..files import require_regular
from ..joints.conventions import JOINT_CONVENTIONS
from ..joints.joint_state import JointMap, JointMemory, OtherJoints
from ..libraries import advise_install
from ..recordings.bags.bag import Bag
from ..recordings.bags.connections import Connection
from ..recordings.bags.messages import DamagedMessage
from ..recordings.bags.opening import open_bag
from ..recordings.frame_readers import JointFrameReader
from ..recordings.motion import Frame, Place
from ..recordings.stamps import read_header_stamp
from ..types import Floats
from .outputs import decode_fact, facts_file
from .topics import BAND, COORDINATE, moment_arm_names, read_label

FACTS_DRAWN = ('muscle', 'side', 'joint_convention', 'heads')


def read_processed(path: Path) -> ProcessedRecording:
    """Read a processed recording.

    Parameters
    ----------
    path
        An output of `linkedplane process`: a bag, .csv or .parquet.

    Raises
    ------
    RecordingError
        If it cannot be read, or is no such output.
    """
    if not path.exists():
        raise RecordingError(f'{path}: no such file or folder')
    if path.is_dir():
        return read_annotated_bag(path)
    require_regular(path, RecordingError)
    try:
        facts, columns = read_parquet(path) if path.suffix.lower() == '.parquet' else read_csv(path)
        return assemble(path, facts, columns)
    except RecordingError:
        raise
    except KeyError as error:
        raise RecordingError(
            f'{path}: not an output of linkedplane process: no {error} in it'
        ) from None
    except (AttributeError, TypeError, ValueError) as error:
        raise RecordingError(
            f'{path}: not an output of linkedplane process: {str(error).splitlines()[0]}'
        ) from None


def read_csv(path: Path) -> tuple[dict[str, str], dict[str, Floats]]:
    """Return the facts, in it or beside it, and the columns of a CSV output."""
    facts: dict[str, str] = {}
    with path.open(encoding='utf-8', newline='') as file:
        for line in file:
            if not line.startswith('#'):
                break
            name, _, fact = line[1:].strip().partition(': ')
            facts[name] = decode_fact(fact)
        else:
            line = ''
        names = next(csv.reader([line]), [])
        values = [[float(cell) if cell else np.nan for cell in row] for row in csv.reader(file)]
    numbers = np.array(values, dtype=np.float64).reshape(len(values), len(names))
    if not facts and any(name.startswith('band_lengths/') for name in names):
        facts = read_facts(path)
    return facts, dict(zip(names, numbers.T, strict=True))


def read_facts(table: Path) -> dict[str, str]:
    """Return the facts that stand in a file beside a plain CSV."""
    path = facts_file(table)
    require_regular(path, RecordingError)
    try:
        facts = dict(yaml.safe_load(path.read_text(encoding='utf-8')))
    except FileNotFoundError:
        raise RecordingError(f'{table}: {path.name} is not beside it') from None
    except OSError as error:
        raise RecordingError(f'{path}: cannot be read: {error.strerror}') from None
    except (yaml.YAMLError, TypeError, ValueError):
        raise RecordingError(f'{path}: not YAML of the form name: value') from None
    if missing := [name for name in FACTS_DRAWN if name not in facts]:
        raise RecordingError(f'{path}: no {missing[0]!r} in it')
    return facts


def read_parquet(path: Path) -> tuple[dict[str, str], dict[str, Floats]]:
    """Return the facts and the columns of a Parquet output."""
    try:
        from pyarrow.parquet import read_table
    except ImportError:
        raise RecordingError(
            f'{path}: Parquet needs the pyarrow library: {advise_install("pyarrow")}'
        ) from None
    table = read_table(path)
    facts = {k.decode(): v.decode() for k, v in (table.schema.metadata or {}).items()}
    return facts, {
        name: table[name].to_numpy().astype(np.float64)
        for name in table.column_names
        if name != 'stamp'
    }


def read_annotated_bag(path: Path) -> ProcessedRecording:
    """Return what an annotated bag holds."""
    require_regular(path / 'metadata.yaml', RecordingError)
    try:
        content = yaml.safe_load((path / 'metadata.yaml').read_text(encoding='utf-8'))
        facts = content['rosbag2_bagfile_information']['custom_data']
        muscle = facts['muscle']
        names = read_coordinates(facts)
        ones, zeros = (1.0,) * len(names), (0.0,) * len(names)
        joints = JointMap(names, ones, zeros)
        topic = facts['angles_topic']
        if not topic:
            topic, joints = facts['topic'], JointMap.from_facts(facts)
    except (OSError, KeyError, TypeError, ValueError, yaml.YAMLError):
        raise RecordingError(f'{path}: not an annotated bag of linkedplane process') from None
    return assemble(
        path, facts, read_bag_columns(path, muscle, JointFrameReader(topic, JointMemory(joints)))
    )


def read_coordinates(facts: Mapping[str, str]) -> tuple[str, ...]:
    """Return the coordinates in an output's facts; KeyError or ValueError for none."""
    if 'coordinates' in facts:
        return tuple(json.loads(facts['coordinates']))
    return JOINT_CONVENTIONS[facts['joint_convention']].coordinates


def read_bag_columns(path: Path, muscle: str, frame_reader: JointFrameReader) -> dict[str, Floats]:
    """Return the columns of an annotated bag: the angles and the answers to them."""
    frames, answers, names = read_answers(path, muscle, frame_reader)
    bands, coordinates = names[BAND], names[COORDINATE]
    angles = np.array([frame.angles for frame in frames])
    columns = {'time': np.array(answers['band_states']) * 1e-9}
    columns |= {f'angles/{name}': each for name, each in zip(coordinates, angles.T, strict=True)}
    for topic in ('band_lengths', 'wrap_states'):
        values = np.array(answers[topic]).T
        columns |= {f'{topic}/{band}': each for band, each in zip(bands, values, strict=True)}
    pairs = [f'moment_arms/{name}' for name in moment_arm_names(bands, coordinates)]
    return columns | dict(zip(pairs, np.array(answers['moment_arms']).T, strict=True))


def read_answers(
    path: Path, muscle: str, frame_reader: JointFrameReader
) -> tuple[list[Frame], dict[str, list[Any]], dict[str, tuple[str, ...]]]:
    """Return the answered frames of an annotated bag, the answers by topic, and their labels.

    The labels are the names of bands and coordinates, by the kind of the dimension.
    """
    wanted = {f'/{muscle}/{name}': name for name in ('band_lengths', 'moment_arms', 'wrap_states')}
    answers: dict[str, list[Any]] = {name: [] for name in (*wanted.values(), 'band_states')}
    frames: list[Frame] = []
    answered: list[Frame] = []
    names: dict[str, tuple[str, ...]] = {}
    with closing(open_bag(path)) as bag:
        for connection, time, data, *_ in bag.messages():
            topic = connection.topic
            if frame_reader.accepts(topic, connection.kind):
                message = read_bag_message(bag, connection, data)
                with suppress(OtherJoints):
                    made = list(frame_reader.read_frames(message, topic, Place(0, time)))
                    frames = [each for each in made if isinstance(each, Frame)] or frames
            elif topic == f'/{muscle}/band_states':  # their stamps are those of the frames
                answers['band_states'].append(read_header_stamp(topic, connection.kind, data))
            elif topic in wanted:
                message = read_bag_message(bag, connection, data)
                answers[wanted[topic]].append(message.data)
                names = dict(read_label(dim.label) for dim in message.layout.dim) | names
                if wanted[topic] == 'band_lengths':  # the first answer to a frame
                    answered += frames
        bag.require_whole()
    return answered, answers, names


def read_bag_message(bag: Bag, connection: Connection, data: bytes) -> Any:
    """Return a message from its bytes; RecordingError, with its bag and topic, if damaged."""
    try:
        return bag.read_message(connection, data)
    except DamagedMessage as error:
        raise RecordingError(f'{bag.path}: a message on {connection.topic} is {error}') from None


def assemble(
    path: Path, facts: Mapping[str, str], columns: Mapping[str, Floats]
) -> ProcessedRecording:
    """Return the columns of an output as arrays; KeyError or ValueError if they are not there."""
    coordinates = tuple(name[7:] for name in columns if name.startswith('angles/'))
    bands = tuple(name[13:] for name in columns if name.startswith('band_lengths/'))
    arms = [columns[f'moment_arms/{name}'] for name in moment_arm_names(bands, coordinates)]
    times = columns['time']
    if not len(times):
        raise RecordingError(f'{path}: no frames in it')
    return ProcessedRecording(
        title=f'{path.name}: {facts["muscle"]}, {facts["side"]}, {facts["joint_convention"]}',
        heads={head: tuple(names) for head, names in json.loads(facts['heads']).items()},
        bands=bands,
        coordinates=coordinates,
        times=times,
        angles=np.column_stack([columns[f'angles/{each}'] for each in coordinates]),
        lengths=np.column_stack([columns[f'band_lengths/{band}'] for band in bands]),
        arms=np.column_stack(arms).reshape(len(times), len(bands), -1),
        wrap=np.column_stack([columns[f'wrap_states/{band}'] for band in bands]).astype(np.uint8),
    )
