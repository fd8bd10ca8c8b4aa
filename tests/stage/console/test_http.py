"""The HTTP interface and its page: what it serves, and whom it refuses."""

import re
import ssl
import time
import urllib.request
from io import BytesIO

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from subsea.base.system import resource_path
from subsea.stage.console import http
from subsea.stage.console.commands import NAMES, ShowCaption, StartTour
from subsea.stage.console.http import RateLimit, script_words
from tests.stage.console.conftest import STATE, TOKEN


def test_it_shows_the_state_and_a_picture(console):
    status, state, _ = console.ask("/api/state")
    assert status == 200 and state == STATE
    status, data, headers = console.ask("/api/picture.jpg")
    assert status == 200 and headers["Content-Type"] == "image/jpeg"
    picture = Image.open(BytesIO(data))
    assert picture.size == (64, 36)
    assert (
        picture.convert("L").getpixel((2, 1)) < 40 < 200 < picture.convert("L").getpixel((60, 34))
    )


def test_no_picture_is_made_while_nobody_looks(console):
    console.ask("/api/state")
    assert not console.board.picture_wanted and console.board.picture_number == 0


def test_commands_reach_the_dive(console):
    status, said, _ = console.ask("/api/commands", {"command": "tour", "name": "reef"})
    assert (status, said) == (200, {"done": "done"})
    status, said, _ = console.ask("/api/commands", {"command": "caption", "text": "refuse"})
    assert (status, said) == (409, {"error": "the dive refuses"})
    assert console.dive.taken == [StartTour("reef"), ShowCaption("refuse")]


def test_all_commands_are_listed(console):
    _, listed, _ = console.ask("/api/commands")
    assert [one["command"] for one in listed] == list(NAMES)


def test_a_command_that_is_not_taken_is_withdrawn(console, monkeypatch):
    monkeypatch.setattr(http, "APPLIED_S", 0.2)
    console.dive.stops = True
    status, said, _ = console.ask("/api/commands", {"command": "helm"})
    assert status == 503 and "busy" in said["error"]
    console.dive.stops = False
    assert console.ask("/api/commands", {"command": "stop-tour"})[0] == 200
    assert [type(one).__name__ for one in console.dive.taken] == ["StopTour"]


def test_prometheus_reads_figures(guarded):
    assert guarded.ask("/metrics")[0] == 401
    status, data, headers = guarded.ask("/metrics", Authorization=f"Bearer {TOKEN}")
    assert status == 200 and headers.get_content_type() == "text/plain"
    lines = [line for line in data.decode().splitlines() if not line.startswith("#")]
    values = {name: float(value) for name, value in (line.split(" ") for line in lines)}
    assert values["subsea_alive"] == 1.0 and values["subsea_up_seconds"] == 100.0
    assert 0.0 <= values["subsea_frame_age_seconds"] < 10.0


def test_a_picture_of_a_node(guarded):
    known = {"Authorization": f"Bearer {TOKEN}"}
    assert guarded.ask("/api/nodes/left.jpg")[0] == 401
    assert guarded.ask("/api/nodes/left.jpg", **known)[:2] == (204, b"")
    guarded.board.node_pictures = {"left": b"\xff\xd8jpeg"}
    status, data, headers = guarded.ask("/api/nodes/left.jpg", **known)
    assert (status, data) == (200, b"\xff\xd8jpeg")
    assert headers.get_content_type() == "image/jpeg"
    assert guarded.ask("/api/nodes/..%2Fkeys.jpg", **known)[0] in (204, 404)
    assert set(guarded.dive.nodes_wanted) <= {"left", "../keys"}


def test_health_tells_whether_pictures_are_drawn(guarded, monkeypatch):
    status, said, _ = guarded.ask("/health")
    assert (status, said) == (200, {"status": "ok"})  # no more for strangers
    _, said, _ = guarded.ask("/health", Authorization=f"Bearer {TOKEN}")
    assert said["status"] == "ok" and said["up_s"] == 100.0 and said["frame_age_s"] < 1.0
    guarded.dive.alive = False
    monkeypatch.setattr("subsea.stage.console.board.ALIVE_S", 0.05)
    time.sleep(0.2)
    status, said, _ = guarded.ask("/health")
    assert (status, said) == (503, {"status": "stuck"})


@pytest.mark.parametrize("path", ["/api/state", "/api/picture.jpg", "/api/commands", "/logout"])
@pytest.mark.parametrize("given", ["", "Bearer ", f"Bearer {TOKEN}x", f"Basic {TOKEN}", "Bearer é"])
def test_without_the_token_nothing_is_shown(guarded, path, given):
    content = {} if path == "/logout" else None
    given = given.encode().decode("latin-1")
    status, said, _ = guarded.ask(path, content, **({"Authorization": given} if given else {}))
    assert status == 401 and said == {"error": "the token is missing or wrong"}
    assert guarded.ask(path, content, Authorization=f"Bearer {TOKEN}")[0] == 200


def test_the_cookie_of_a_login_is_as_good_as_the_token_and_does_not_show_it(guarded):
    assert guarded.ask("/login", {"token": "wrong" * 10})[0] == 401
    status, _, headers = guarded.ask("/login", {"token": TOKEN})
    cookie = headers["Set-Cookie"]
    assert status == 200 and "HttpOnly" in cookie and "SameSite=Strict" in cookie
    assert TOKEN not in cookie
    assert guarded.ask("/api/state", Cookie=cookie.partition(";")[0])[0] == 200


@pytest.mark.parametrize(
    "content", [b"", b"\xff", b"[]", b'{"token": 7}', b'{"token": "\\ud800"}', b"[" * 4000, b"{}"]
)
def test_a_login_without_a_token_is_refused(guarded, content):
    assert guarded.ask("/login", content)[0] in (401, 422)


@pytest.mark.parametrize(
    ("host", "status"),
    [("127.0.0.1:PORT", 200), ("localhost:PORT", 200), ("[::1]:PORT", 200), ("10.0.0.7:PORT", 200),
     ("evil.example:PORT", 421), ("127.0.0.1", 421), ("127.0.0.1:1", 421),
     ("127.0.0.1.evil.example:PORT", 421), ("", 421), ("[", 421), ("localhost:99999999", 421)],
)  # fmt: skip
def test_a_host_of_another_name_is_refused(console, host, status):
    """As of a name that its owner lets point to this computer (DNS rebinding)."""
    assert console.ask("/api/state", Host=host.replace("PORT", str(console.port)))[0] == status


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_other_sites_are_refused(console, site):
    command = {"command": "blank", "on": True}
    for headers in (
        {"Origin": "https://evil.example"},
        {"Origin": "null"},
        {"Origin": f"https://{console.host}"},  # another scheme is another origin
        {"Sec_Fetch_Site": site},
    ):
        assert console.ask("/api/commands", command, **headers)[0] == 403
        assert console.ask("/api/state", **headers)[0] == 403
    assert console.ask("/", Sec_Fetch_Site=site)[0] == 200  # a link to the page
    assert console.dive.taken == []
    own = {"Origin": f"http://{console.host}", "Sec_Fetch_Site": "same-origin"}
    assert console.ask("/api/commands", command, **own)[0] == 200


@pytest.mark.parametrize("kind", ["text/plain", "application/x-www-form-urlencoded", ""])
def test_a_form_cannot_send_commands(console, kind):
    status, _, _ = console.ask("/api/commands", b'{"command":"helm"}', Content_Type=kind)
    assert status == 415 and console.dive.taken == []


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "not JSON"),
        (b"\xff\xfe", "not JSON"),
        (b"[" * 3000, "not JSON"),
        (b"[1, 2]", "expected"),
        (b'{"command": 7}', "expected"),
        (b'{"command": "reboot"}', "unknown command 'reboot'"),
        (b'{"command": "tour", "name": 7}', "expected text"),
        (b'{"command": "tour"}', "missing key"),
        (b'{"command": "tour", "name": "reef", "more": 1}', "unknown key"),
        (b'{"command": "blank", "on": 2}', "expected true or false"),
        (b'{"command": "volume", "volume": 1.5}', "at most 1"),
        (b'{"command": "volume", "volume": NaN}', "not JSON"),
        (b'{"command": "quality", "quality": "best"}', "unknown value"),
        (b'{"command": "caption", "text": "%s"}' % (b"a" * 301), "300 characters"),
    ],
)
def test_what_is_no_command_is_refused_in_one_line(console, content, words):
    status, said, _ = console.ask("/api/commands", content)
    assert status == 422 and words in said["error"] and "\n" not in said["error"]
    assert console.dive.taken == []
    assert console.board.refusals.state.text == f"HTTP: {said['error']}"


def test_paths_lead_nowhere_else(console):
    for path in ("/../pyproject.toml", "/%2e%2e/pyproject.toml", "/console.css/../x", "/static"):
        assert console.ask(path)[0] == 404
    assert console.ask("/api/state", {})[0] == 405
    assert console.ask("/console.js")[1] == resource_path("assets/console/console.js").read_bytes()


def test_every_answer_forbids_what_is_not_ours(console):
    for path in ("/", "/api/state", "/nothing"):
        headers = console.ask(path)[2]
        policy = headers["Content-Security-Policy"]
        assert policy.startswith("default-src 'none'; script-src 'self'; style-src 'self'")
        assert "unsafe" not in policy and "frame-ancestors 'none'" in policy
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["Cross-Origin-Resource-Policy"] == "same-origin"
        assert "Python" not in headers["Server"] and "aiohttp" not in headers["Server"]


@pytest.mark.parametrize("name", http.PAGES.values())
def test_the_pages_have_no_scripts_of_their_own_and_all_of_their_words(name):
    page = http.filled(http.read_asset(name))
    scripts = r'<script(?! type="module" src=)|\son\w+=|<style|style=|javascript:'
    assert not re.search(scripts, page)
    assert "{{" not in page and "http" not in page
    assert "@" not in page


@pytest.mark.parametrize("name", ["client.js", "console.js", "line-up.js"])
def test_scripts_write_text_alone_and_every_text_is_marked(name):
    script = resource_path(f"assets/console/{name}").read_text()
    assert not re.search(r"\beval\b|innerHTML|outerHTML|insertAdjacentHTML|document\.write", script)
    said = re.findall(r'\bsay\(("[^"]+")?', script)
    assert "" not in said and {text[1:-1] for text in said} <= {*script_words()}


@pytest.mark.parametrize(
    ("asked", "code", "blank"),
    [
        ("de-AT,de;q=0.9,en;q=0.8", "de", "Schwarz"),
        ("ja", "ja", "黒画面"),
        ("pt-BR, fr;q=0.5", "fr", "Noir"),
        ("tlh", "en", "Blank"),
        ("\u00ff;,,-;q=x" * 50, "en", "Blank"),
    ],
)
def test_the_page_is_in_the_browsers_language(console, asked, code, blank):
    page = console.ask("/", Accept_Language=asked)[1].decode()
    assert f'<html lang="{code}">' in page and f">{blank}<" in page
    words = console.ask("/words", Accept_Language=asked)[1]
    assert list(words) == list(dict.fromkeys(script_words()))
    assert (words["No tour."] == "No tour.") == (code == "en")


def test_tls_and_a_token_as_for_other_computers(secure, certificate):
    context = ssl.create_default_context(cafile=certificate[0])
    request = urllib.request.Request(
        secure.options.url + "api/state", headers={"Authorization": f"Bearer {TOKEN}"}
    )
    with urllib.request.urlopen(request, context=context, timeout=30) as answer:
        assert answer.status == 200
    assert secure.options.url.startswith("https://")
    old = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    old.check_hostname, old.verify_mode = False, ssl.CERT_NONE
    with pytest.warns(DeprecationWarning):
        old.maximum_version = ssl.TLSVersion.TLSv1_1
    with pytest.raises(OSError):
        urllib.request.urlopen(request, context=old, timeout=30)


@given(st.lists(st.floats(0.0, 0.2), max_size=200))
def test_no_more_than_the_rate_is_let_through(gaps):
    now = [0.0]
    limit = RateLimit(10.0, 5, lambda: now[0])
    assert [limit.allow() for _ in range(6)] == [True] * 5 + [False]
    now[0] = 60.0
    passed = []
    for gap in gaps:
        now[0] += gap
        if limit.allow():
            passed.append(now[0])
    assert len(passed) >= min(len(gaps), 5)
    for k, begin in enumerate(passed):
        within = sum(begin <= moment < begin + 1.0 for moment in passed[k:])
        assert within <= 5 + 10 + 1
