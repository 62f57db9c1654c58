# SPDX-License-Identifier: Apache-2.0
"""A browser that keeps its socket open and takes nothing of what it is sent is disconnected."""

from __future__ import annotations

import contextlib
import io
import socket
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from browser import wait_until
from optional import requires
from socket_browser import CAMERA

from linkedplane_ros.viewer import guard as guarding
from linkedplane_ros.viewer.guard import Guard
from linkedplane_ros.viewer.main import find_port

if TYPE_CHECKING:
    import viser

pytestmark = requires('viser')
TRIANGLES = np.arange(30000).reshape(-1, 3)  # 0.5 MB in each frame
BOUND = 100.0  # s: some ten are meant, on a machine that has nothing else to do


class MuteSocket:
    """A browser's side of the viewer's socket that says hello, and then reads when it is told."""

    def __init__(self, port: int, token: str) -> None:
        import msgspec
        import viser
        from websockets.client import ClientProtocol
        from websockets.uri import parse_uri

        uri = parse_uri(f'ws://127.0.0.1:{port}/?token={token}')
        protocol = ClientProtocol(
            uri,
            subprotocols=[f'viser-v{viser.__version__}'],  # type: ignore[list-item]
        )
        self.socket = socket.socket()
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.socket.settimeout(60.0)
        self.socket.connect(('127.0.0.1', port))
        protocol.send_request(protocol.connect())
        self._send(protocol)
        while not protocol.events_received():
            protocol.receive_data(self.socket.recv(1))
        protocol.send_binary(msgspec.msgpack.encode(CAMERA))  # from here on it looks on
        self._send(protocol)

    def _send(self, protocol: Any) -> None:
        for data in protocol.data_to_send():
            self.socket.sendall(data)


@pytest.fixture
def served() -> Iterator[tuple[viser.ViserServer, Callable[[], MuteSocket]]]:
    """Run the library's server as the viewer does."""
    import viser

    guard = Guard('127.0.0.1')
    port = find_port('127.0.0.1', 0)
    with contextlib.redirect_stdout(io.StringIO()), guard.guard_server():
        server = viser.ViserServer('127.0.0.1', port, verbose=False)
    guard.set_server(server)
    yield server, lambda: MuteSocket(server.get_port(), guard.token)
    server.stop()


def test_a_browser_that_takes_nothing_of_a_stream_is_disconnected(
    served: tuple[viser.ViserServer, Callable[[], MuteSocket]],
) -> None:
    server, connect = served
    mute = connect()
    assert wait_until(lambda: len(server.get_clients()) == 1)
    mesh = server.scene.add_mesh_simple('/mesh', np.zeros((30000, 3)), TRIANGLES)
    random = np.random.default_rng(0)

    def gone() -> bool:
        mesh.vertices = random.random((30000, 3))  # every 50 ms: about 10 MB/s
        return not server.get_clients()

    assert wait_until(gone, BOUND)
    assert not server._websock_server._live_connections  # nor is it held behind the scenes
    mute.socket.close()


def test_a_browser_that_takes_a_large_picture_slowly_is_kept(
    served: tuple[viser.ViserServer, Callable[[], MuteSocket]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It takes something within each of the times in which it has to."""
    monkeypatch.setattr(guarding, 'STUCK', 3.0)
    server, connect = served
    slow = connect()
    assert wait_until(lambda: len(server.get_clients()) == 1)
    server.scene.add_mesh_simple('/mesh', np.zeros((600000, 3)), np.zeros((4, 3), int))
    turns = 0

    def reads() -> bool:
        nonlocal turns
        turns += 1
        slow.socket.recv(1 << 14)
        return turns > 200  # 10 s: of 50 ms each, before its pings count as missed

    assert wait_until(reads)
    assert len(server.get_clients()) == 1
    slow.socket.close()


def test_a_connection_that_a_browser_opens_ahead_and_closes_unused_is_not_logged(
    served: tuple[viser.ViserServer, Callable[[], MuteSocket]], caplog: pytest.LogCaptureFixture
) -> None:
    server, connect = served
    for said in (b'', b'GET / HT'):
        with socket.create_connection(('127.0.0.1', server.get_port())) as ahead:
            ahead.sendall(said)
    after = connect()
    assert wait_until(lambda: len(server.get_clients()) == 1)
    assert [each.name for each in caplog.records if 'websockets' in each.name] == []
    after.socket.close()
