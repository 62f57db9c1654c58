# SPDX-License-Identifier: Apache-2.0
"""The viewer in a browser, against another page and other programs of this machine."""

from __future__ import annotations

import http.client
from collections.abc import Iterator
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any, ClassVar
from urllib.parse import urlsplit

import pytest
from browser import WINDOW, Page, open_browser, wait_until
from ros_harness import Reader
from sensor_msgs.msg import JointState
from viewer_stage import MISSING, ViewerProcess

pytestmark = [pytest.mark.skipif(bool(MISSING), reason=MISSING), pytest.mark.browser]
ATTACK = """async ([address, version]) => {
  const found = {};
  const within = promise => Promise.race(
    [promise, new Promise(done => setTimeout(() => done('nothing'), 5000))]);
  for (const [name, options] of [['cors', {}], ['kept', {credentials: 'include'}]]) {
    found[name] = await fetch(address, options).then(each => each.text(), () => 'nothing');
  }
  found.opaque = await fetch(address, {mode: 'no-cors', credentials: 'include'})
    .then(each => each.text(), () => 'nothing');
  const framed = document.createElement('iframe');
  framed.src = address;
  document.body.append(framed);
  found.framed = await within(new Promise(done => framed.onload = () => {
    try { done(framed.contentDocument.body.innerText || 'nothing'); } catch { done('nothing'); }
  }));
  const socket = new WebSocket(address.replace('http', 'ws'), ['viser-v' + version]);
  found.socket = await within(new Promise(done => {
    socket.onmessage = () => done('a message');
    socket.onopen = () => done('open');
    socket.onerror = () => done('nothing');
  }));
  return found;
}"""

# Each way of a script to reach another address; what it reaches is for that to say
REACH = """async address => {
  const refused = [];
  document.addEventListener('securitypolicyviolation',
    event => refused.push(event.effectiveDirective));
  const tries = {
    fetch: () => fetch(address + '/fetch', {mode: 'no-cors'}).catch(() => 0),
    xhr: () => {
      const request = new XMLHttpRequest();
      request.open('GET', address + '/xhr');
      request.send();
    },
    beacon: () => navigator.sendBeacon(address + '/beacon', 'x'),
    events: () => new EventSource(address + '/events'),
    socket: () => new WebSocket(address.replace('http', 'ws') + '/socket'),
    image: () => { new Image().src = address + '/image'; },
    frame: () => add('iframe', 'frame'),
    script: () => add('script', 'script'),
    form: () => {
      const place = document.createElement('iframe');
      place.name = 'hidden';
      document.body.append(place);
      const form = add('form', 'form');
      form.action = address + '/form';
      form.method = 'post';
      form.target = 'hidden';
      form.submit();
    },
  };
  const add = (tag, path) => {
    const made = document.createElement(tag);
    made.src = address + '/' + path;
    document.body.append(made);
    return made;
  };
  for (const attempt of Object.values(tries)) {
    try { await attempt(); } catch { /* refused at once */ }
  }
  await new Promise(done => setTimeout(done, 2000));
  return refused;
}"""


class Elsewhere(BaseHTTPRequestHandler):
    """Another page of this machine; it keeps the paths that it was asked for."""

    asked: ClassVar[list[str]] = []

    def do_GET(self) -> None:
        """Answer with an empty page."""
        self.asked.append(self.path)
        self.send_response(200)
        self.send_header('Content-Type', 'text/html')
        self.end_headers()
        self.wfile.write(b'<!doctype html><title>elsewhere</title><body></body>')

    do_POST = do_GET

    def log_message(self, *_: Any) -> None:
        """Say nothing."""


@pytest.fixture
def elsewhere() -> Iterator[str]:
    with ThreadingHTTPServer(('127.0.0.1', 0), Elsewhere) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f'http://127.0.0.1:{server.server_port}'
        server.shutdown()


def test_the_printed_address_works_and_another_page_reads_no_byte_and_moves_nothing(
    tmp_path: Path, elsewhere: str, ros: None
) -> None:
    import viser

    heard: list[JointState] = []
    listener = Reader('listener')
    listener.keep(JointState, '/muscle_viewer/joint_states', heard.append)
    with ViewerProcess(tmp_path / 'viewer.log', '--node') as viewer, open_browser() as chromium:
        context = chromium.new_context(viewport=WINDOW)
        page = Page(context.new_page(), viewer.url)
        page.press_button('neutral')
        assert wait_until(lambda: len(page.lines()) > 0), viewer.text
        page.page.reload()
        assert wait_until(lambda: len(page.lines()) > 0)
        page.move_slider(0, 40.0)
        assert listener.until(lambda: bool(heard) and heard[-1].position[0] > 0.5)
        bare = urlsplit(viewer.url)._replace(query='').geturl()
        assert page.page.evaluate('document.cookie') == ''  # no script reads the token
        for address in (elsewhere, elsewhere.replace('127.0.0.1', 'localhost')):
            other = context.new_page()  # it has the cookie of the first
            other.goto(address)
            for target in (bare, viewer.url):
                found = other.evaluate(ATTACK, [target, viser.__version__])
                assert set(found.values()) <= {'nothing', ''}, (address, target, found)
            other.close()
        again = Page(context.new_page(), bare + '?')  # the cookie serves a second page
        assert wait_until(lambda: len(again.lines()) > 0)
        stranger = chromium.new_context().new_page()
        assert stranger.goto(bare).status == 403
        assert 'token' in stranger.content()
        assert page.errors == []
    listener.destroy_node()


def test_a_script_of_the_page_reaches_no_other_address(
    tmp_path: Path, elsewhere: str, ros: None
) -> None:
    with ViewerProcess(tmp_path / 'viewer.log') as viewer, open_browser() as chromium:
        context = chromium.new_context(viewport=WINDOW)
        free = context.new_page()
        free.goto(elsewhere)
        Elsewhere.asked.clear()
        free.evaluate(REACH, elsewhere)
        ways = {'/fetch', '/xhr', '/beacon', '/events', '/socket', '/image', '/frame', '/script'}
        assert {*ways, '/form'} <= set(Elsewhere.asked)  # else it shows nothing
        page = Page(context.new_page(), viewer.url)
        assert wait_until(lambda: page.page.get_by_text('Waiting for a muscle').count() > 0)
        assert page.errors == []
        Elsewhere.asked.clear()
        refused = page.page.evaluate(REACH, elsewhere)
        assert Elsewhere.asked == []
        assert refused.count('connect-src') == 5, refused
        assert {'img-src', 'frame-src', 'script-src-elem', 'form-action'} <= set(refused)


def ask(host: str, port: int, path: str, headers: dict[str, str]) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection(host, port, timeout=30.0)
    connection.request('GET', path, headers=headers)
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, body


def test_a_request_for_a_foreign_host_or_from_a_foreign_page_is_refused(tmp_path: Path) -> None:
    with ViewerProcess(tmp_path / 'viewer.log') as viewer:
        url = urlsplit(viewer.url)
        assert url.port is not None
        get = partial(ask, '127.0.0.1', url.port, f'/?{url.query}')
        upgrade = {
            'Upgrade': 'websocket',
            'Connection': 'Upgrade',
            'Sec-WebSocket-Version': '13',
            'Sec-WebSocket-Key': 'dGhlIHNhbXBsZSBub25jZQ==',
        }
        own = {'Host': url.netloc}
        assert get(own)[0] == 200
        assert b'viser' in get(own)[1]
        for long in ('x' * 300, 'x' * 8000):
            assert ask('127.0.0.1', url.port, f'/{long}?{url.query}', own)[0] == 404
        for more in ({}, upgrade):
            for wrong in (
                {'Host': 'evil.example'},
                {'Host': f'evil.example:{url.port}'},
                {**own, 'Origin': 'http://evil.example'},
                {**own, 'Origin': 'null'},
            ):
                status, body = get({**wrong, **more})
                assert (status, body.count(b'\n')) == (403, 1)
                assert b'viser' not in body
        assert ask('127.0.0.1', url.port, '/', {**own, **upgrade})[0] == 403  # without the token
        assert ask('127.0.0.1', url.port, '/index.html', own)[0] == 403
    assert 'Traceback' not in viewer.text
