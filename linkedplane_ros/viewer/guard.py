# SPDX-License-Identifier: Apache-2.0
"""Who may open the viewer, and what a browser may say: checked before the library sees it.

viser (1.1.0 and 1.1.1 were read and tried) serves its page and its socket with `serve` of the
library websockets. It checks neither Host nor Origin nor what a message holds, and has no password.
So each request, and each message, passes through here first. A version of viser that is served in
another way is refused: it would be open.

* A request needs the Host under which this machine is reached (DNS rebinding), no other page's
  Origin (cross-site), and the token of the printed address; the page gets it as a cookie.
* A message needs to be one that this page sends, with finite numbers within their ranges.
"""

from __future__ import annotations

import hmac
import inspect
import logging
import re
import secrets
import socket
from asyncio import TimerHandle
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from http import HTTPStatus
from importlib.metadata import version
from ipaddress import ip_address
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qsl, urlsplit

from ..errors import LinkedPlaneError
from .messages import find_message_fault

if TYPE_CHECKING:
    import viser
    from websockets import Headers

LOOPBACK_NAMES = ('127.0.0.1', 'localhost', '[::1]')  # a browser resolves none of them by DNS
WILDCARDS = ('', '0.0.0.0', '::')
TOKEN_BYTES = 24
HTTP_PORT = 80
IN_QUERY = re.compile(r'[?&]token=([0-9A-Za-z]+)')
FOREIGN = ('cross-site', 'same-site')  # Sec-Fetch-Site of what another page asks for
ELSEWHERE = {'websocket', 'playbackPath'}  # where else viser's page would read from
KEEP_ALIVE = {'ping_interval': 2.0, 'ping_timeout': 8.0, 'close_timeout': 1.0}  # s
STUCK = 8.0  # s in which a browser has to take some of what waits for it
QUEUE = 1 << 17  # bytes that the system holds for it: more would hide for long what it takes
POLICY = '; '.join(
    (
        "default-src 'self' 'unsafe-inline' 'unsafe-eval' data: blob:",  # the page is one file
        "connect-src 'self' ws://{host} data: blob:",
        "frame-ancestors 'none'",
        "base-uri 'none'",
        "form-action 'none'",
    )
)


class Guard:
    """Checks the requests and the messages of one server."""

    def __init__(self, host: str, report: Callable[[str], None] = lambda line: None) -> None:
        """`host` is what the server listens on; `report` gets a line for each refused message."""
        self.token = secrets.token_hex(TOKEN_BYTES)
        self._report = report
        self._names = set(LOOPBACK_NAMES)
        if host not in WILDCARDS:
            self._names.add(host.lower())
        self._guarded = False
        self._controls: Mapping[str, Any] = {}

    @contextmanager
    def guard_server(self) -> Iterator[None]:
        """Guard the server that viser starts in the block."""
        from websockets.asyncio import server

        original = server.serve

        def serve(handler: Any, *where: Any, process_request: Any, **options: Any) -> Any:
            self._guarded = True
            options['create_connection'] = self._checked_connection()
            options['process_request'] = self._checked_requests(process_request)
            options |= KEEP_ALIVE  # a browser that hangs ends its sweep as one that closes
            # of a connection that a browser opens ahead and closes unused, it logs a traceback
            options['logger'] = logging.Logger('connections', logging.CRITICAL)
            return original(handler, *where, **options)

        server.serve = serve  # type: ignore[assignment,misc]
        try:
            yield
        finally:
            server.serve = original  # type: ignore[misc]

    def set_server(self, server: viser.ViserServer) -> None:
        """Take the controls that browsers may change from the server that was started."""
        controls = getattr(server.gui, '_gui_input_handle_from_uuid', None)
        if not self._guarded or not isinstance(controls, dict):
            server.stop()
            raise LinkedPlaneError(
                f'viser {version("viser")} cannot be guarded against other pages; 1.1.1 can'
            )
        self._controls = controls

    def _checked_connection(self) -> type:
        """Return websockets' connection without refused messages, and ended when it is stuck."""
        from websockets.asyncio.server import ServerConnection

        guard = self

        class CheckedConnection(ServerConnection):
            _watch: TimerHandle | None = None

            def connection_made(self, transport: Any) -> None:
                own = transport.get_extra_info('socket')
                own.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, QUEUE)
                super().connection_made(transport)

            def pause_writing(self) -> None:
                """Watch a browser that takes less than it is sent: its pings wait as well."""
                super().pause_writing()
                self._look_again()

            def resume_writing(self) -> None:
                self._stop_watch()
                super().resume_writing()

            def connection_lost(self, error: Exception | None) -> None:
                self._stop_watch()
                super().connection_lost(error)

            def _look_again(self) -> None:
                left = self.transport.get_write_buffer_size()
                self._watch = self.loop.call_later(STUCK, self._end_if_stuck, left)

            def _end_if_stuck(self, before: int) -> None:
                if self.transport.get_write_buffer_size() < before:
                    self._look_again()
                else:
                    self.transport.abort()

            def _stop_watch(self) -> None:
                if self._watch is not None:
                    self._watch.cancel()

            async def recv(self, decode: bool | None = None) -> Any:
                while True:
                    message = await super().recv(decode)
                    fault = find_message_fault(message, guard._controls)
                    if not fault:
                        return message
                    guard._report(f'a browser sent what is not used: {fault}')

        return CheckedConnection

    def _checked_requests(self, answer: Any) -> Any:
        """Return what answers requests, without those that are refused."""

        async def answer_checked(connection: Any, request: Any) -> Any:
            address, port = connection.local_address[:2]
            fault = self.find_request_fault(address, port, request.path, request.headers)
            if fault:
                return connection.respond(HTTPStatus.FORBIDDEN, f'muscle_viewer: {fault}\n')
            try:
                response = answer(connection, request)
                if inspect.isawaitable(response):
                    response = await response
            except (OSError, ValueError):  # a path that no file can have, as a very long one
                response = connection.respond(HTTPStatus.NOT_FOUND, 'NOT FOUND')
            if response is not None:
                self._add_headers(response.headers, port, request.headers['Host'])
            return response

        return answer_checked

    def _add_headers(self, headers: Headers, port: int, host: str) -> None:
        cookie = f'{cookie_name(port)}={self.token}; Path=/; HttpOnly; SameSite=Strict'
        headers['Set-Cookie'] = cookie
        headers['Content-Security-Policy'] = POLICY.format(host=host)
        headers['Cross-Origin-Resource-Policy'] = 'same-origin'
        headers['Referrer-Policy'] = 'no-referrer'  # the token stays here
        headers['X-Content-Type-Options'] = 'nosniff'
        headers['Cache-Control'] = 'no-store'

    def find_request_fault(self, address: str, port: int, path: str, headers: Headers) -> str:
        """Return why a request is refused, or nothing.

        Parameters
        ----------
        address, port
            Where it arrived on this machine.
        path
            Of the request, with its query.
        headers
            Its headers.

        """
        hosts = [each.lower() for each in headers.get_all('Host')]
        served = self._served_hosts(address, port)
        if len(hosts) != 1 or hosts[0] not in served:
            return f'the header Host has to be one of {", ".join(sorted(served))}'
        origins = [each.lower() for each in headers.get_all('Origin')]
        if origins not in ([], [f'http://{hosts[0]}']):
            return 'a page of another address may not use this one'
        embedded = headers.get('Sec-Fetch-Dest') != 'document'
        if embedded and headers.get('Sec-Fetch-Site') in FOREIGN:
            return 'a page of another address may not use this one'
        if ELSEWHERE & {name for name, _ in parse_qsl(urlsplit(path).query, True)}:
            return 'this page shows nothing but this viewer'
        in_cookie = re.compile(rf'(?:^|;\s*){cookie_name(port)}=([0-9A-Za-z]+)')
        given = IN_QUERY.findall(path)
        given += in_cookie.findall('; '.join(headers.get_all('Cookie')))
        if not any(hmac.compare_digest(each, self.token) for each in given):
            return 'open the whole address that was printed; it ends with ?token= and a token'
        return ''

    def _served_hosts(self, address: str, port: int) -> set[str]:
        """Return the values of the header Host under which this machine is reached."""
        ip = ip_address(address.partition('%')[0])
        ip = getattr(ip, 'ipv4_mapped', None) or ip
        names = {*self._names, f'[{ip}]' if ip.version == 6 else str(ip)}
        if not ip.is_loopback:
            own = socket.gethostname().lower()
            names |= {own, f'{own.partition(".")[0]}.local'}
        ports = [f':{port}', *([''] if port == HTTP_PORT else [])]
        return {name + each for name in names for each in ports}


def cookie_name(port: int) -> str:
    """Return the name of the cookie with the token; browsers share cookies between ports."""
    return f'muscle_viewer_{port}'
