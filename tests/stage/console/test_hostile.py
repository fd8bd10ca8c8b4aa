"""Clients that lie, flood and stall: others are served, and nothing is left of them."""

import socket
import ssl
import threading
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.stage.console import http
from tests.stage.console.conftest import TOKEN, Console, local


def connect(console, origin="127.0.0.1"):
    """A raw connection."""
    return socket.create_connection(("127.0.0.1", console.port), 30, (origin, 0))


def request(console, path="/api/state", more=""):
    return f"GET {path} HTTP/1.1\r\nHost: {console.host}\r\n{more}\r\n".encode()


def status_of(client):
    """The status of the answer; 0 if the connection was ended without one."""
    try:
        first = client.recv(64)
    except ConnectionError:
        return 0
    return int(first.split()[1]) if first else 0


def ended_within(client, seconds):
    """True if the other side ends the connection in this time."""
    client.settimeout(seconds)
    try:
        while client.recv(4096):
            pass
    except TimeoutError:
        return False
    except ConnectionError:
        return True
    return True


@pytest.fixture
def hasty(monkeypatch):
    """Times of seconds become fractions."""
    monkeypatch.setattr(http, "IDLE_S", 1.0)
    monkeypatch.setattr(http, "SWEEP_S", 0.1)
    monkeypatch.setattr(http, "HANDSHAKE_S", 0.5)


def trickle(client, data, gap_s=0.1):
    """Send bytes one by one until the other side ends."""
    try:
        for byte in data * 100:
            client.sendall(bytes([byte]))
            time.sleep(gap_s)
    except OSError:
        pass


@pytest.mark.parametrize("sent", [b"", b"GET / HTTP/1.1\r\nHost: x\r\nX-Slow: "])
def test_silent_and_slow_clients_are_ended_while_others_are_served(hasty, console, sent):
    slow = [connect(console) for _ in range(20)]
    threads = [threading.Thread(target=trickle, args=(one, sent)) for one in slow if sent]
    for thread in threads:
        thread.start()
    begun = time.monotonic()
    assert console.ask("/api/state")[0] == 200
    assert time.monotonic() - begun < 5.0
    assert all(ended_within(one, 20.0) for one in slow)
    for thread in threads:
        thread.join()
    for one in slow:
        one.close()


@pytest.mark.nightly
def test_a_body_that_does_not_come_is_not_waited_for(monkeypatch, console):
    monkeypatch.setattr(http, "ANSWER_S", 1.0)
    with connect(console) as client:
        client.sendall(
            f"POST /api/commands HTTP/1.1\r\nHost: {console.host}\r\n"
            "Content-Type: application/json\r\nContent-Length: 100\r\n\r\n{".encode()
        )
        assert status_of(client) == 408
        assert ended_within(client, 10.0)
    assert console.dive.taken == []


def test_a_reader_that_takes_nothing_is_ended(hasty, console):
    console.board.state = b"x" * 4_000_000
    console.dive.state = {"title": "x" * 4_000_000}
    with connect(console) as client:
        client.sendall(request(console) * 8)
        time.sleep(1.6)
        got = 0
        client.settimeout(10.0)
        try:
            while data := client.recv(1 << 20):
                got += len(data)
        except ConnectionError:
            pass
        assert got < 32_000_000  # all of it
    console.dive.state = {}
    assert console.ask("/health")[0] == 200


@pytest.mark.parametrize(
    ("sent", "status"),
    [
        (b"\x16\x03\x01\x02\x00\x01" + b"\x00" * 64, 400),  # TLS to a port without
        (b"GET / HTTP/9.9\r\n\r\n", 400),
        (b"NONSENSE\r\n\r\n", 400),
        (b"GET /" + b"a" * 9000 + b" HTTP/1.1\r\n\r\n", 400),
        (b"GET / HTTP/1.1\r\nX: " + b"a" * 9000 + b"\r\n\r\n", 400),
        (b"GET / HTTP/1.1\r\n" + b"X: a\r\n" * 500 + b"\r\n", 400),
        (b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", None),
        (b"POST /api/commands HTTP/1.1\r\nHost: HOST\r\nContent-Type: application/json\r\n"
         b"Content-Length: 5000\r\n\r\n" + b"a" * 5000, 413),
        (b"POST /api/commands HTTP/1.1\r\nHost: HOST\r\nContent-Type: application/json\r\n"
         b"Content-Length: 99999999999999999999999999\r\n\r\n", None),
        (b"POST /api/commands HTTP/1.1\r\nHost: HOST\r\nContent-Type: application/json\r\n"
         b"Transfer-Encoding: chunked\r\n\r\nffffffffff\r\n", None),
        (b"POST /login HTTP/1.1\r\nHost: HOST\r\nContent-Type: application/json\r\n"
         b"Transfer-Encoding: chunked\r\nContent-Length: 4\r\n\r\n", None),
    ],
)  # fmt: skip
def test_malformed_and_huge_requests_are_refused(hasty, console, sent, status):
    with connect(console) as client:
        try:
            client.sendall(sent.replace(b"HOST", console.host.encode()))
            answer = status_of(client)
        except OSError:
            answer = 0
    assert answer in ((status, 0) if status else (0, 400, 408, 413, 421))
    assert console.dive.taken == []
    assert console.ask("/api/state")[0] == 200


def test_any_bytes_leave_the_console_working():
    console = Console(local())
    try:

        @given(st.binary(max_size=300))
        def send(data):
            with connect(console) as client:
                client.sendall(data)

        send()
        assert console.ask("/api/state")[0] == 200
        assert console.dive.taken == []
    finally:
        console.close()


def test_more_clients_than_allowed_are_turned_away(monkeypatch, console):
    monkeypatch.setattr(http, "CLIENTS", 5)
    held = [connect(console) for _ in range(5)]
    for one in held:
        one.sendall(request(console))
        assert status_of(one) == 200
    with connect(console) as sixth:
        assert ended_within(sixth, 10.0)
    for one in held:
        one.close()
    end = time.monotonic() + 30.0
    while True:  # they are noticed to be gone
        try:
            if console.ask("/api/state")[0] == 200:
                break
        except OSError:
            pass
        assert time.monotonic() < end
        time.sleep(0.1)


def test_strangers_cannot_keep_others_out(monkeypatch, guarded):
    monkeypatch.setattr(http, "CLIENTS", 5)
    trusted = connect(guarded)
    trusted.sendall(request(guarded, more=f"Authorization: Bearer {TOKEN}\r\n"))
    assert status_of(trusted) == 200
    single = connect(guarded, "127.0.0.3")
    crowd = [connect(guarded, "127.0.0.2") for _ in range(3)]
    begun = time.monotonic()
    for _ in range(2):
        assert guarded.ask("/api/state", Authorization=f"Bearer {TOKEN}")[0] == 200
    assert time.monotonic() - begun < 0.5 * http.IDLE_S
    assert ended_within(crowd[0], 1.0)  # the oldest of the address with most of them
    assert not ended_within(single, 0.1) and not ended_within(trusted, 0.1)
    for one in (trusted, single, *crowd):
        one.close()


def test_guesses_of_the_token_are_few_for_strangers_only(guarded):
    begun = time.monotonic()
    seen = [guarded.ask("/login", {"token": "guess" * 10})[0] for _ in range(60)]
    assert set(seen) == {401, 429}
    assert seen.count(401) <= 21 + 10 * (time.monotonic() - begun)
    assert guarded.ask("/api/state", Authorization=f"Bearer {TOKEN}")[0] == 200


def test_handshakes_that_do_not_end_are_ended(hasty, secure):
    silent = [connect(secure) for _ in range(10)]
    garbage = connect(secure)
    garbage.sendall(b"GET / HTTP/1.1\r\n\r\n")
    for one in (*silent, garbage):
        assert ended_within(one, 20.0)
        one.close()
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    with connect(secure) as raw, context.wrap_socket(raw) as client:
        client.sendall(request(secure, "/health"))
        assert status_of(client) == 200


def test_it_ends_at_once_in_the_middle_of_requests(console):
    held = [connect(console) for _ in range(10)]
    for one in held[:5]:
        one.sendall(request(console)[:-2])
    begun = time.monotonic()
    console.server.close()
    assert time.monotonic() - begun < 2.5
    assert not console.server._thread.is_alive()
    for one in held:
        one.close()
