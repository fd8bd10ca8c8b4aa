"""The page and the HTTP interface of the console. The only module that speaks HTTP.

Connections are accepted a few at a time, and ended if they do nothing. The words of the page are
English and are translated for the browser that asks: those between {{ and }} in the pages of
`assets/console`, and those that their scripts give to `say`.
"""

import asyncio
import hmac
import html
import ipaddress
import json
import logging
import re
import socket
import time
from collections import Counter
from collections.abc import Awaitable, Callable
from contextlib import suppress
from io import BytesIO
from typing import Any
from urllib.parse import urlsplit

import msgspec
from aiohttp import web

from subsea.base.errors import UserError
from subsea.base.language import first_known, translated
from subsea.base.system import resource_path
from subsea.stage.console.board import RETRY, Board
from subsea.stage.console.commands import described, from_json
from subsea.stage.console.metrics import metrics
from subsea.stage.console.options import ConsoleOptions

MAX_BODY = 4096  # bytes
MAX_LINE, MAX_HEADERS = 4096, 64  # bytes of a line of a request; lines
ANSWER_S = 8.0  # longest time for a request
APPLIED_S = 3.0  # longest time to wait until the dive has applied a command
KNOWN_A_S, STRANGERS_A_S = 60.0, 10.0  # requests a second of all clients together
JPEG_QUALITY = 70
COOKIE = "subsea-console"
MARKED = r"\{\{(.+?)\}\}"
ASSETS = {
    "/console.css": ("console.css", "text/css"),
    "/client.js": ("client.js", "text/javascript"),
    "/console.js": ("console.js", "text/javascript"),
    "/line-up.js": ("line-up.js", "text/javascript"),
    "/fleet.js": ("fleet.js", "text/javascript"),
    "/icon.svg": ("icon.svg", "image/svg+xml"),
}
PAGES = {"/": "index.html", "/line-up": "line-up.html", "/fleet": "fleet.html"}
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "img-src 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
    "Server": "subsea",
}
OPEN = {*PAGES, "/login", "/words", "/health", *ASSETS}  # paths that need no token

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class RateLimit:
    """Refuses requests that come faster than a rate."""

    def __init__(
        self, per_s: float, burst: int, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """`burst` requests may come at once, then `per_s` in a second. `clock` gives s."""
        self._per_s, self._burst, self._clock = per_s, float(burst), clock
        self._left, self._last_s = float(burst), clock()

    def allow(self) -> bool:
        """Count one more request; False: refuse it."""
        now = self._clock()
        self._left = min(self._left + (now - self._last_s) * self._per_s, self._burst)
        self._last_s = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True


class HttpConsole:
    """Answers requests; made and used in the loop of the server's thread."""

    def __init__(self, options: ConsoleOptions, board: Board) -> None:
        self._options, self._board = options, board
        self._known = RateLimit(KNOWN_A_S, int(KNOWN_A_S))
        self._strangers = RateLimit(STRANGERS_A_S, int(2 * STRANGERS_A_S))
        # A cookie that does not reveal the token, and is the same after a restart.
        self._session = hmac.digest(options.token.encode(), b"session", "sha256").hex()
        self._names = {"localhost", socket.gethostname().lower(), *options.names}
        self._pages = {path: resource_path(f"assets/console/{name}").read_bytes()
                       for path, (name, _) in ASSETS.items()}  # fmt: skip
        self._sources = {path: read_asset(name) for path, name in PAGES.items()}
        self._texts = script_words()
        self._jpeg, self._jpeg_number = b"", 0
        self.answered: dict[Any, float] = {}  # when each connection last had an answer
        self.trusted: set[Any] = set()  # connections that have had the token, or need none

    def runner(self) -> web.AppRunner:
        """The application, with bounds on lines, headers and bodies."""
        app = web.Application(client_max_size=MAX_BODY, middlewares=[self._guard])
        for path in PAGES:
            app.router.add_get(path, self._page)
        for path in ASSETS:
            app.router.add_get(path, self._asset)
        app.router.add_get("/health", self._health)
        app.router.add_get("/metrics", self._metrics)
        app.router.add_post("/login", self._login)
        app.router.add_post("/logout", self._logout)
        app.router.add_get("/words", self._words)
        app.router.add_get("/api/state", self._state)
        app.router.add_get("/api/picture.jpg", self._picture)
        app.router.add_get("/api/nodes/{name}.jpg", self._node_picture)
        app.router.add_get("/api/commands", self._list)
        app.router.add_post("/api/commands", self._command)
        silent = logging.Logger("console")
        silent.addHandler(logging.NullHandler())
        return web.AppRunner(
            app, handle_signals=False, shutdown_timeout=0.5, access_log=None, logger=silent,
            max_line_size=MAX_LINE, max_field_size=MAX_LINE, max_headers=MAX_HEADERS,
            lingering_time=1.0, keepalive_timeout=ANSWER_S, read_bufsize=2 * MAX_BODY,
        )  # fmt: skip

    @web.middleware
    async def _guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Check who asks and how often, answer in bounded time, and add the headers."""
        try:
            async with asyncio.timeout(ANSWER_S):
                answer = await self._checked(request, handler)
        except web.HTTPException as refusal:
            answer = fault(refusal.status, refusal.reason)
        except TimeoutError:
            answer = fault(408, "too slow")
        except Exception:  # a defect here must not show its inside, nor end the dive
            answer = fault(500, "a defect of the console")
        answer.headers.update(HEADERS)
        if answer.status >= 400:
            answer.force_close()
        if request.transport is not None:  # else the client has gone
            self.answered[request.protocol] = asyncio.get_running_loop().time()
            if self._is_known(request):
                self.trusted.add(request.protocol)
        return answer

    async def _checked(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        known = self._is_known(request)
        if not (self._known if known else self._strangers).allow():
            refused = fault(429, "too many requests")
            refused.headers["Retry-After"] = "2"
            return refused
        if not self._is_own_host(request):
            return fault(421, "this is not the name or address of the console")
        if not is_own_origin(request):
            return fault(403, "requests of other sites are refused")
        if not known and request.path not in OPEN:
            return fault(401, "the token is missing or wrong")
        if request.method == "POST" and request.content_type != "application/json":
            return fault(415, "expected Content-Type: application/json")
        return await handler(request)

    def _is_known(self, request: web.Request) -> bool:
        """True if a request has the token, or needs none. The time tells nothing about it."""
        if not self._options.token:
            return True
        scheme, _, given = request.headers.get("Authorization", "").partition(" ")
        cookie = request.cookies.get(COOKIE, "")
        by_token = scheme.lower() == "bearer" and same(given.strip(), self._options.token)
        return by_token or same(cookie, self._session)

    def _is_own_host(self, request: web.Request) -> bool:
        """True for an address or a known name; another may be an attack by DNS rebinding."""
        try:
            host = urlsplit(f"//{request.headers.get('Host', '')}")
            name, port = host.hostname or "", host.port
        except ValueError:
            return False
        usual = 443 if self._options.tls else 80
        if (port or usual) != self._options.http.port:
            return False
        with suppress(ValueError):
            ipaddress.ip_address(name)
            return True
        return name in self._names

    async def _page(self, request: web.Request) -> web.Response:
        text = self._sources[request.path]
        page = filled(text, bool(self._options.token), language_of(request))
        return web.Response(text=page, content_type="text/html")

    async def _asset(self, request: web.Request) -> web.Response:
        return web.Response(
            body=self._pages[request.path], content_type=ASSETS[request.path][1], charset="utf-8"
        )

    async def _health(self, request: web.Request) -> web.Response:
        """The state for monitors: 503 if the dive has stopped drawing; details for the known."""
        alive = self._board.alive
        answer: dict[str, Any] = {"status": "ok" if alive else "stuck"}
        if self._is_known(request):
            age = self._board.beat_age_s
            answer["frame_age_s"] = None if age == float("inf") else round(age, 3)
            answer |= json.loads(self._board.health)
        return web.json_response(answer, status=200 if alive else 503)

    async def _metrics(self, request: web.Request) -> web.Response:
        """Give figures in the text format of Prometheus."""
        board = self._board
        text = metrics(json.loads(board.health), board.alive, board.beat_age_s)
        return web.Response(text=text, content_type="text/plain")

    async def _login(self, request: web.Request) -> web.Response:
        """Take the token of `{"token": …}`; the answer sets a cookie."""
        try:
            given = msgspec.json.decode(await request.read(), type=dict[str, str]).get("token")
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
            return fault(422, 'expected {"token": TEXT}')
        if self._options.token and not same(given or "", self._options.token):
            return fault(401, "the token is wrong")
        answer = web.json_response({"done": "logged in"})
        if self._options.token:
            answer.set_cookie(
                COOKIE, self._session, httponly=True, samesite="Strict", max_age=30 * 86400,
                secure=self._options.tls is not None,
            )  # fmt: skip
        return answer

    async def _logout(self, request: web.Request) -> web.Response:
        answer = web.json_response({"done": "logged out"})
        answer.del_cookie(COOKIE)
        return answer

    async def _words(self, request: web.Request) -> web.Response:
        code = language_of(request)
        return web.json_response({text: translated(text, code) for text in self._texts})

    async def _state(self, request: web.Request) -> web.Response:
        alive = {"Dive": "alive" if self._board.alive else "stuck"}
        return web.Response(body=self._board.state, content_type="application/json", headers=alive)

    async def _list(self, request: web.Request) -> web.Response:
        return web.json_response(described())

    async def _picture(self, request: web.Request) -> web.Response:
        """The latest picture; the first request waits for one."""
        board, before = self._board, self._board.picture_number
        fresh = board.picture_wanted
        board.want_picture()
        loop = asyncio.get_running_loop()
        end = loop.time() + 2.0
        while not fresh and board.picture_number == before and loop.time() < end:
            await asyncio.sleep(0.05)
        if board.picture is None:
            return fault(503, "no picture yet")
        if self._jpeg_number != board.picture_number:
            self._jpeg_number = board.picture_number
            self._jpeg = jpeg_of(board.picture)
        return web.Response(body=self._jpeg, content_type="image/jpeg")

    async def _node_picture(self, request: web.Request) -> web.Response:
        """The last picture of a node, 204 without one; the next one is asked for."""
        name = request.match_info["name"][:64]
        self._board.want_node(name)
        jpeg = self._board.node_pictures.get(name)
        if jpeg is None:
            return web.Response(status=204)
        return web.Response(body=jpeg, content_type="image/jpeg")

    async def _command(self, request: web.Request) -> web.Response:
        """Give a command to the dive and wait for its result."""
        try:
            command = from_json(await request.read())
        except UserError as reason:
            self._board.refusals.add(f"HTTP: {reason}")
            return fault(422, str(reason))
        try:
            done = self._board.put(command)
        except UserError as reason:
            self._board.refusals.add(f"HTTP: {reason}")
            return fault(503, str(reason))
        await asyncio.wait({asyncio.wrap_future(done)}, timeout=APPLIED_S)
        if done.cancel():  # it had not begun, and will not
            return fault(503, RETRY)
        if not done.done():
            return web.json_response({"done": "under way"}, status=202)
        if (refusal := done.exception()) is not None:
            return fault(409, str(refusal))
        return web.json_response({"done": done.result()})


def language_of(request: web.Request) -> str:
    """The first of the browser's languages that the catalogues have."""
    return first_known(request.headers.get("Accept-Language", "").split(","))


def read_asset(name: str) -> str:
    """Read a file of the page."""
    return resource_path(f"assets/console/{name}").read_text("utf-8")


def page_words() -> list[str]:
    """List the texts of the pages."""
    return [text for name in PAGES.values() for text in re.findall(MARKED, read_asset(name))]


def script_words() -> list[str]:
    """List the texts of the scripts of the pages."""
    scripts = [name for name, kind in ASSETS.values() if kind == "text/javascript"]
    found = [re.findall(r'\bsay\("([^"]+)"', read_asset(name)) for name in scripts]
    return list(dict.fromkeys(text for texts in found for text in texts))


def filled(text: str, token: bool = False, code: str = "en") -> str:
    """Translate the page, and say whether it needs a `token`."""
    text = text.replace("@language", code).replace("@needs_token", "yes" if token else "no")
    return re.sub(MARKED, lambda marked: html.escape(translated(marked[1], code)), text)


def fault(status: int, reason: str) -> web.Response:
    """A refusal with its reason as JSON."""
    return web.json_response({"error": reason}, status=status)


def same(given: str, known: str) -> bool:
    """Compare in constant time."""
    return hmac.compare_digest(given.encode("utf-8", "replace"), known.encode())


def is_own_origin(request: web.Request) -> bool:
    """False if a page of another site sent the request, as its browser says."""
    if request.headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin"):
        # A link from elsewhere may open a page, but nothing else.
        return request.method == "GET" and request.path in PAGES
    origin = request.headers.get("Origin")
    return origin is None or origin.lower() == f"{request.scheme}://{request.host}".lower()


def jpeg_of(picture: Any) -> bytes:
    """A JPEG of pixels (h, w, 4)."""
    from PIL import Image

    out = BytesIO()
    Image.fromarray(picture[..., :3]).save(out, "JPEG", quality=JPEG_QUALITY)
    return out.getvalue()


CLIENTS = 128  # connections at once
OF_ONE = 16  # of one address that is not this computer's
ACCEPTS_A_S, REFUSALS_A_S = 50.0, 1000.0
HANDSHAKE_S = 5.0  # longest time for that of TLS
IDLE_S = ANSWER_S + 4.0  # without an answer, also while a request trickles in
SWEEP_S = 1.0


class Connections:
    """The open connections of the HTTP console, made in the loop of the server's thread."""

    def __init__(self, options: ConsoleOptions, http: HttpConsole, factory: Any) -> None:
        """`factory` makes the protocol of a connection, and lists them in `connections`."""
        self._options, self._http, self._factory = options, http, factory
        self._sockets: dict[socket.socket, str] = {}  # that are open, with their address
        self._protocols: dict[socket.socket, Any] = {}  # of those whose handshake is over
        self._tasks: dict[socket.socket, asyncio.Task[None]] = {}

    async def accept(self, listener: socket.socket) -> None:
        """Accept connections for ever; of too many, one without the token makes room."""
        loop, pause_s = asyncio.get_running_loop(), 0.0
        while True:
            await asyncio.sleep(pause_s)
            try:
                client, address = await loop.sock_accept(listener)
            except OSError:  # no file number is left, or the client has gone
                await asyncio.sleep(0.5)
                continue
            origin = address[0]
            local = self._options.http.ip.is_loopback
            crowded = Counter(self._sockets.values())[origin] >= OF_ONE and not local
            if crowded or (len(self._sockets) >= CLIENTS and not self._makes_room()):
                client.close()
                pause_s = 1.0 / REFUSALS_A_S  # cheap: a flood must not keep others waiting
                continue
            pause_s = 1.0 / ACCEPTS_A_S
            self._sockets[client] = origin
            self._tasks[client] = loop.create_task(self._serve(client))

    def _makes_room(self) -> bool:
        """End the oldest connection without the token, of the address with most of them."""
        known = self._http.trusted
        strangers = {client: origin for client, origin in self._sockets.items()
                     if self._protocols.get(client) not in known}  # fmt: skip
        if not strangers:
            return False
        [(most, _)] = Counter(strangers.values()).most_common(1)
        client = next(client for client, origin in strangers.items() if origin == most)
        self._tasks[client].cancel()
        del self._sockets[client]
        return True

    async def _serve(self, client: socket.socket) -> None:
        """Serve one connection to its end."""
        loop, tls = asyncio.get_running_loop(), self._options.tls
        transport: asyncio.Transport | None = None
        try:
            limit = HANDSHAKE_S if tls else None
            transport, protocol = await loop.connect_accepted_socket(
                self._factory, client, ssl=tls, ssl_handshake_timeout=limit
            )
            begun, self._protocols[client] = loop.time(), protocol
            while protocol in self._factory.connections and not transport.is_closing():
                await asyncio.sleep(SWEEP_S)
                last = self._http.answered.get(protocol, begun)
                if loop.time() - last > IDLE_S:
                    transport.abort()
        except (TimeoutError, OSError, EOFError):  # a failed handshake
            pass
        finally:
            self._sockets.pop(client, None)
            self._tasks.pop(client, None)
            protocol = self._protocols.pop(client, None)
            self._http.answered.pop(protocol, None)
            self._http.trusted.discard(protocol)
            if transport is not None:
                transport.abort()
            else:
                client.close()

    async def close(self) -> None:
        """End all connections."""
        tasks = list(self._tasks.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await asyncio.sleep(0)  # the transports close now
