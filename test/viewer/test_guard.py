# SPDX-License-Identifier: Apache-2.0
"""Who may open the viewer, and what a browser may send: the checks alone, without a browser."""

from __future__ import annotations

import asyncio
import math
from http import HTTPStatus
from types import SimpleNamespace
from typing import Any

import pytest
from optional import requires

from linkedplane_ros import LinkedPlaneError
from linkedplane_ros.viewer.guard import Guard, cookie_name
from linkedplane_ros.viewer.messages import find_message_fault

pytestmark = requires('viser')
PORT = 8080
HOST = f'127.0.0.1:{PORT}'
ENDS = {'label': 'flexion (deg)', 'min': -40.0, 'max': 120.0}
CONTROLS = {
    'slider': SimpleNamespace(**ENDS, disabled=False, visible=True),
    'still': SimpleNamespace(**ENDS, disabled=True, visible=True),
    'unseen': SimpleNamespace(**ENDS, disabled=False, visible=False),
    'choice': SimpleNamespace(
        label='colour by', options=('head', 'moment arm'), disabled=False, visible=True
    ),
    'box': SimpleNamespace(label='axes', disabled=False, visible=True),
}
CAMERA = {
    'type': 'ViewerCameraMessage',
    'wxyz': [1.0, 0.0, 0.0, 0.0],
    'position': [1.0, 2.0, 3.0],
    'fov': 0.6,
    'near': 1.0,
    'far': 200.0,
    'image_height': 720,
    'image_width': 956,
    'look_at': [0.0, 0.0, 0.0],
    'up_direction': [0.0, 0.0, 1],
}


def ask(
    guard: Guard, *headers: tuple[str, str], path: str | None = None, address: str = '127.0.0.1'
) -> str:
    """Return why a request is refused; without headers it comes from the address bar."""
    from websockets import Headers

    path = f'/?token={guard.token}' if path is None else path
    return guard.find_request_fault(address, PORT, path, Headers(headers or (('Host', HOST),)))


@pytest.mark.parametrize(
    'host', ['127.0.0.1:8080', 'localhost:8080', 'LOCALHOST:8080', '[::1]:8080']
)
def test_the_printed_address_is_served_and_its_page_is(host: str) -> None:
    guard = Guard('127.0.0.1')
    assert ask(guard, ('Host', host)) == ''
    assert ask(guard, ('Host', host), ('Origin', f'http://{host}')) == ''


@pytest.mark.parametrize(
    'headers',
    [
        [],  # HTTP/1.0
        [('Host', 'evil.example:8080')],
        [('Host', 'evil.example')],
        [('Host', '127.0.0.1:9090')],
        [('Host', '127.0.0.1')],
        [('Host', '127.0.0.1:8080.evil.example')],
        [('Host', 'evil.example@127.0.0.1:8080')],
        [('Host', 'localhost.:8080')],
        [('Host', '0.0.0.0:8080')],
        [('Host', '192.0.2.7:8080')],
        [('Host', '')],
        [('Host', HOST), ('Host', 'evil.example')],
    ],
    ids=str,
)
def test_a_foreign_host_is_refused_whatever_the_token(headers: list[tuple[str, str]]) -> None:
    guard = Guard('127.0.0.1')
    assert 'Host' in ask(guard, *(headers or [('Accept', '*/*')]))


@pytest.mark.parametrize(
    'header',
    [
        ('Origin', 'http://evil.example'),
        ('Origin', 'http://evil.example:8080'),
        ('Origin', 'http://127.0.0.1:8081'),
        ('Origin', 'http://127.0.0.1'),
        ('Origin', 'http://localhost:8080'),
        ('Origin', f'https://{HOST}'),
        ('Origin', f'http://{HOST}.evil.example'),
        ('Origin', 'null'),
        ('Origin', ''),
        ('Sec-Fetch-Site', 'cross-site'),
        ('Sec-Fetch-Site', 'same-site'),  # another port of this machine: it has the cookie
    ],
    ids=str,
)
def test_another_pages_request_is_refused_whatever_the_token(header: tuple[str, str]) -> None:
    assert 'another address' in ask(Guard('127.0.0.1'), ('Host', HOST), header)


def test_a_link_to_the_printed_address_may_be_followed() -> None:
    link = ('Sec-Fetch-Site', 'cross-site'), ('Sec-Fetch-Dest', 'document')
    assert ask(Guard('127.0.0.1'), ('Host', HOST), *link) == ''


@pytest.mark.parametrize(
    'path', ['/', '/?token=', '/?token=0', '/index.html', '/?tokens={}', '/{}']
)
def test_without_the_token_nothing_is_served_on_loopback_too(path: str) -> None:
    guard = Guard('127.0.0.1')
    assert 'token' in ask(guard, path=path.format(guard.token))
    other = Guard('127.0.0.1').token
    assert other != guard.token
    assert 'token' in ask(guard, path=f'/?token={other}')


@pytest.mark.parametrize('more', ['websocket=ws://evil.example', '%77ebsocket=', 'playbackPath=a'])
def test_a_link_that_has_the_page_read_elsewhere_is_refused(more: str) -> None:
    guard = Guard('127.0.0.1')
    assert 'nothing but this viewer' in ask(guard, path=f'/?token={guard.token}&{more}')


def test_the_token_is_taken_from_the_cookie_of_this_port_alone() -> None:
    guard = Guard('127.0.0.1')
    for name, refused in ((cookie_name(PORT), False), (cookie_name(9090), True), ('token', True)):
        cookie = ('Cookie', f'a=b; {name}={guard.token}; c=d')
        assert bool(ask(guard, ('Host', HOST), cookie, path='/')) == refused


def test_a_server_for_others_is_served_under_the_address_that_was_reached() -> None:
    guard = Guard('0.0.0.0')
    for address, host, refused in (
        ('192.0.2.7', '192.0.2.7:8080', False),
        ('192.0.2.7', '192.0.2.8:8080', True),
        ('192.0.2.7', 'evil.example:8080', True),
        ('2001:db8::7', '[2001:db8::7]:8080', False),
        ('::ffff:192.0.2.7', '192.0.2.7:8080', False),
        ('127.0.0.1', 'localhost:8080', False),
    ):
        assert bool(ask(guard, ('Host', host), address=address)) == refused, host
    assert ask(Guard('robot.example'), ('Host', 'Robot.example:8080'), address='192.0.2.7') == ''


def test_a_library_that_serves_in_another_way_is_stopped_in_one_line() -> None:
    stopped: list[bool] = []
    server: Any = SimpleNamespace(gui=SimpleNamespace(), stop=lambda: stopped.append(True))
    for guarded, controls in ((False, {}), (True, None)):
        guard = Guard('127.0.0.1')
        if guarded:
            guard._guarded = True
        server.gui._gui_input_handle_from_uuid = controls
        with pytest.raises(LinkedPlaneError, match='cannot be guarded'):
            guard.set_server(server)
    assert stopped == [True, True]


# What a browser sends


def fault(message: Any) -> str:
    import msgspec

    return find_message_fault(msgspec.msgpack.encode(message), CONTROLS)


def change(uuid: str, value: Any) -> str:
    return fault({'type': 'GuiUpdateMessage', 'uuid': uuid, 'updates': {'value': value}})


@pytest.mark.parametrize(
    ('uuid', 'value'),
    [
        ('slider', -40),
        ('slider', 119.9),
        ('choice', 'moment arm'),
        ('box', True),
        ('gone', 'its page is not up to date'),
    ],
)
def test_what_a_person_can_set_is_taken(uuid: str, value: Any) -> None:
    assert change(uuid, value) == ''


@pytest.mark.parametrize(
    ('uuid', 'value'),
    [
        *(('slider', value) for value in (math.nan, math.inf, -math.inf, 120.1, -41, 1e300, 2**63)),
        *(('slider', value) for value in ('nan', '10', True, None, [10.0], {'a': 1}, b'1')),
        ('still', 10.0),
        ('unseen', 10.0),
        *(('choice', value) for value in ('<b>', '', 0, None, ['head'], math.nan)),
        *(('box', value) for value in (1, 0.0, 'true', None, math.nan)),
    ],
    ids=str,
)
def test_what_nobody_can_set_is_refused_with_the_name_of_its_control(uuid: str, value: Any) -> None:
    found = change(uuid, value)
    assert found.startswith(CONTROLS[uuid].label)
    assert '\n' not in found


@pytest.mark.parametrize(
    'message',
    [
        {'type': 'GuiUpdateMessage', 'uuid': 'slider', 'updates': {'max': 1e9}},
        {'type': 'GuiUpdateMessage', 'uuid': 'slider', 'updates': {'value': 1, 'update_cb': []}},
        {'type': 'GuiUpdateMessage', 'uuid': 'slider', 'updates': {}},
        {'type': 'GuiUpdateMessage', 'uuid': 'slider', 'updates': [1]},
        {'type': 'GuiUpdateMessage', 'uuid': ['slider'], 'updates': {'value': 1}},
        {'type': 'GuiUpdateMessage', 'uuid': 'slider'},
        {'type': 'ShareUrlRequest'},
        {'type': 'FileTransferPart', 'content': b''},
        {'type': 'NoSuchMessage'},
        {'type': math.nan},
        {'type': 'GetRenderResponseMessage', 'payload': 'text', 'render_uuid': 'a'},
        {'type': 'GetRenderResponseMessage', 'payload': b'', 'render_uuid': 'a', 'more': 1},
        {},
        [],
        None,
        'text',
        {**CAMERA, 'position': [math.nan, 0.0, 0.0]},
        {**CAMERA, 'position': [0.0, 0.0]},
        {**CAMERA, 'fov': math.inf},
        {**CAMERA, 'look_at': 'nan'},
        {**CAMERA, 'far': 1e300},
        {**CAMERA, 'image_width': -1},
        {**CAMERA, 'more': 0},
    ],
    ids=lambda message: str(message)[:40],
)
def test_what_the_page_never_sends_is_refused(message: Any) -> None:
    assert fault(message)


def test_bytes_that_are_no_message_are_refused_and_a_camera_is_taken() -> None:
    assert fault(CAMERA) == ''
    assert fault({'type': 'GetRenderResponseMessage', 'payload': b'1', 'render_uuid': 'a'}) == ''
    for message in (
        'text',
        b'',
        b'\xc1',
        b'\x81' * 5000,
        b'\xa4\xff\xff\xff\xff',
        b'\x91' * 100000,
    ):
        assert find_message_fault(message, CONTROLS) == 'it is no message of this page'


# How it is served


def test_a_browser_that_hangs_is_gone_after_about_ten_seconds(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from websockets.asyncio import server

    given: dict[str, Any] = {}
    monkeypatch.setattr(server, 'serve', lambda *_, **options: given.update(options))
    with Guard('127.0.0.1').guard_server():
        server.serve(None, process_request=None)  # type: ignore[arg-type]
    timeouts = [given[name] for name in ('ping_interval', 'ping_timeout', 'close_timeout')]
    assert 10.0 <= sum(timeouts) <= 12.0
    assert given['ping_timeout'] >= 8.0  # a browser on a loaded machine answers within


@pytest.mark.parametrize('error', [OSError(36, 'File name too long'), ValueError('null byte')])
def test_a_path_that_no_file_can_have_is_not_found(error: Exception) -> None:
    from websockets import Headers

    def answer(*_: Any) -> None:
        raise error

    guard = Guard('127.0.0.1')
    connection = SimpleNamespace(
        local_address=('127.0.0.1', PORT),
        respond=lambda status, text: SimpleNamespace(status=status, headers=Headers()),
    )
    path = f'/{"x" * 300}?token={guard.token}'
    request = SimpleNamespace(path=path, headers=Headers({'Host': HOST}))
    response = asyncio.run(guard._checked_requests(answer)(connection, request))
    assert response.status == HTTPStatus.NOT_FOUND
