# SPDX-License-Identifier: Apache-2.0
"""A browser's side of the viewer's socket: quick, and free to say anything."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from unhurried import PATIENCE

CAMERA = {
    'type': 'ViewerCameraMessage',
    'wxyz': (1.0, 0.0, 0.0, 0.0),
    'position': (4.0, 4.0, 1.0),
    'fov': 0.6,
    'near': 1.0,
    'far': 200.0,
    'image_height': 720,
    'image_width': 956,
    'look_at': (0.0, 0.0, 0.0),
    'up_direction': (0.0, 0.0, 1.0),
}


class SocketBrowser:
    """A browser that looks on and changes controls, by their labels."""

    def __init__(self, url: str, **headers: str) -> None:
        """Connect to a printed address; `Origin` and others may be given."""
        import viser
        from websockets.sync.client import connect

        self.texts: dict[str, str] = {}
        self.places: dict[str, dict[str, tuple[float, ...]]] = {}  # where parts of the scene stand
        self._controls: dict[str, str] = {}
        self._disabled: dict[str, bool] = {}
        self._socket = connect(
            url.replace('http', 'ws'),
            subprotocols=[f'viser-v{viser.__version__}'],  # type: ignore[list-item]
            additional_headers=headers,
            max_size=None,
            compression=None,
        )
        self.send(CAMERA)  # from here on it looks on

    def __enter__(self) -> SocketBrowser:
        """Look on."""
        return self

    def __exit__(self, *_: object) -> None:
        """Leave, as a page that is closed."""
        self._socket.close()

    def send(self, message: dict[str, Any] | bytes) -> None:
        """Send a message."""
        import msgspec

        encoded = message if isinstance(message, bytes) else msgspec.msgpack.encode(message)
        self._socket.send(encoded)

    def set_control(self, label: str, value: Any) -> None:
        """Change a control once it is there."""
        assert self.until(lambda: label in self._controls), [*self._controls]
        uuid = self._controls[label]
        self.send({'type': 'GuiUpdateMessage', 'uuid': uuid, 'updates': {'value': value}})

    def waits_for(self, label: str) -> bool:
        """Wait until a control can be changed; return whether that came."""
        return self.until(lambda: not self._disabled.get(self._controls[label], False))

    @property
    def labels(self) -> list[str]:
        """The labels of all controls."""
        return [*self._controls]

    def shows(self, text: str) -> bool:
        """Wait for a text in the panel; return whether it came."""
        return self.until(lambda: any(text in each for each in self.texts.values()))

    def until(self, condition: Callable[[], bool], seconds: float = PATIENCE) -> bool:
        """Read what the viewer sends until a condition holds; return whether it did in time."""
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                return False
            self._read(0.05)
        return True

    def _read(self, seconds: float) -> None:
        import msgspec
        import zstandard

        try:
            data = self._socket.recv(timeout=seconds)
        except TimeoutError:
            return
        assert isinstance(data, bytes)
        size = int.from_bytes(data[8:16], 'little')
        packed = zstandard.ZstdDecompressor().decompress(data[16 : 16 + size])
        for message in msgspec.msgpack.decode(packed)['messages']:
            props = message.get('props')
            if isinstance(props, dict) and 'uuid' in message:
                self._controls[props.get('label') or ''] = message['uuid']
                if 'content' in props:
                    self.texts[message['uuid']] = props['content']
            elif message['type'] == 'GuiUpdateMessage' and 'content' in message['updates']:
                self.texts[message['uuid']] = message['updates']['content']
            elif message['type'] == 'GuiUpdateMessage' and 'label' in message['updates']:
                self._controls[message['updates']['label']] = message['uuid']
            elif message['type'] == 'GuiUpdateMessage' and 'disabled' in message['updates']:
                self._disabled[message['uuid']] = message['updates']['disabled']
            elif message['type'] in ('SetPositionMessage', 'SetOrientationMessage'):
                part = self.places.setdefault(message['name'], {})
                part.update({key: message[key] for key in ('position', 'wxyz') if key in message})
