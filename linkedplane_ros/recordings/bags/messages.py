# SPDX-License-Identifier: Apache-2.0
"""The messages of a bag, out of their bytes."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from ...errors import RecordingError
from .connections import Connection, TypeDefinition


class DamagedMessage(RecordingError):
    """A message whose bytes are not one of its type."""


class MessageReader:
    """Makes messages of bytes, by the definitions of a bag or those of ROS 2 Jazzy.

    Only what is asked for is looked at: the definitions beside it may be missing, incomplete, or in
    a language that the rosbags library does not read (its AnyReader 0.11.9 refuses such bags).
    """

    def __init__(self) -> None:
        """Load the definitions of ROS 2."""
        from rosbags.typesys import Stores, get_typestore

        self._known = get_typestore(Stores.ROS2_JAZZY)
        self._stores: dict[tuple[str, TypeDefinition], Any] = {}

    def read_message(self, connection: Connection, data: bytes) -> Any:
        """Return a message from its bytes.

        Messages that rclpy serialised may end in up to 12 surplus bytes, which rosbags refuses;
        then they are cut off.

        Raises
        ------
        DamagedMessage
            If they are not those of a message of its type.
        """
        kind = connection.msgtype
        store = self._stores.get((kind, connection.definition))
        if store is None:
            store = self._choose_store(kind, connection.definition)
            self._stores[kind, connection.definition] = store
        try:
            return store.deserialize_cdr(data, kind)
        except Exception:
            for surplus in (4, 8, 12):
                with suppress(Exception):
                    return store.deserialize_cdr(data[:-surplus], kind)
        raise DamagedMessage(f'damaged: its {len(data):,} bytes are no whole {kind}')

    def _choose_store(self, kind: str, definition: TypeDefinition) -> Any:
        """Return the definitions by which a type is read: the bag's if it has more, else ROS's."""
        known = self._known.fielddefs
        own = parse_definition(kind, definition)
        if own is None or own.hash_rihs01(kind) == self._known.hash_rihs01(kind):
            return self._known
        whole = all(
            dict(known[name][1]).items() <= dict(fields).items()
            for name, (_, fields) in own.fielddefs.items()
            if name in known
        )
        return own if whole else self._known


def split_idl(text: str) -> list[str]:
    """Return the parts of a definition in IDL, a file each; rosbag2 writes a line before each."""
    first, *rest = text.split('=' * 80 + '\n')
    return [each.partition('\n')[2] for each in rest] or [first]


def parse_definition(kind: str, definition: TypeDefinition) -> Any:
    """Return a store of a type and all types in it; None if the definition does not give it."""
    from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

    text = definition.text.decode(errors='replace')
    if not text.strip():
        return None
    store = get_typestore(Stores.EMPTY)
    with suppress(Exception):  # whatever may stand there
        if definition.encoding in ('ros2idl', 'omgidl'):
            types = {}
            for part in split_idl(text):
                types.update(get_types_from_idl(part))
            store.register(types)
        else:
            store.register(get_types_from_msg(text, kind))
        store.hash_rihs01(kind)  # needs all types in it
        return store
    return None
