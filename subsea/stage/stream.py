"""Send what a window shows as a live stream: H.264 in MPEG-TS by SRT, RTP or UDP.

The dive leaves its latest picture; a thread encodes it at the stream's own rate and sends it. So
neither a receiver that is slow or gone nor the encoder holds the picture up.
"""

import ipaddress
import time
from argparse import ArgumentParser, Namespace
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from threading import Event, Lock, Thread
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, urlencode, urlsplit

import numpy as np

from subsea.base.arrays import Bytes
from subsea.base.errors import UserError, unknown
from subsea.base.files import read_text, refuse_shared
from subsea.base.progress import say
from subsea.dive import arguments as shared
from subsea.dive.part import DivePart

if TYPE_CHECKING:
    from subsea.dive.options import DiveOptions
    from subsea.stage.small_picture import SmallPicture
    from subsea.ui.dive import Dive

FORMATS = {"srt": "mpegts", "rtp": "rtp_mpegts", "udp": "mpegts"}
FPS = 30
WIDTH = 1280  # of the stream at most, pixels
BITS = 0.1  # of a pixel in a picture
AGAIN_S = 2.0  # between two attempts to send
WAIT_US = 1_000_000  # for a receiver, or for one that takes nothing
LATENCY_MS = 120  # of SRT, in which lost packets are sent again
SHORTEST, LONGEST = 10, 79  # letters of a passphrase of SRT
TTL = 4  # networks that a multicast packet may pass
QUERY = ("mode", "latency", "ttl")


@dataclass(frozen=True)
class StreamOptions:
    """Where a stream goes, and what of."""

    url: str  # checked
    window: str | None = None  # of a theatre; None: the front one
    width: int = WIDTH
    fps: int = FPS
    passphrase: str = ""

    @property
    def scheme(self) -> str:
        """The protocol: srt, rtp or udp."""
        return urlsplit(self.url).scheme

    @property
    def listens(self) -> bool:
        """True if receivers call, which only SRT knows."""
        return _listens(self.url)


def stream_options(
    url: str, passphrase_file: Path | None = None, window: str | None = None, width: int = WIDTH
) -> StreamOptions:
    """Check the place of a stream; a UserError for one that is unsafe or does not exist.

    Receivers of other computers may call only with a passphrase.
    """
    option = f"--stream {url}"
    parts, ip = _parts(url)
    query = parse_qs(parts.query)
    if odd := [key for key in query if key not in QUERY]:
        hint = "; give it in --stream-passphrase FILE" if "passphrase" in odd else ""
        raise UserError(f"{option}: {odd[0]!r} after the ?, expected {', '.join(QUERY)}{hint}")
    passphrase = ""
    if passphrase_file is not None:
        if parts.scheme != "srt":
            raise UserError(f"{option}: only srt:// has passphrases")
        passphrase = read_text(passphrase_file).strip()
        refuse_shared(passphrase_file)
        if not SHORTEST <= len(passphrase) <= LONGEST or not passphrase.isascii():
            what = f"expected a passphrase of {SHORTEST} to {LONGEST} letters and digits"
            raise UserError(what, file=passphrase_file)
    if _listens(url) and not ip.is_loopback and not passphrase:
        raise UserError(
            f"{option}: other computers may call it: expected --stream-passphrase FILE, or an "
            "address of this computer, such as srt://127.0.0.1:9000?mode=listener"
        )
    return StreamOptions(url, window, width, FPS, passphrase)


def _parts(url: str) -> tuple[Any, Any]:
    """The parts of the URL of a stream, and its IP address; a UserError for anything else."""
    parts = urlsplit(url)
    try:
        if parts.scheme not in FORMATS or parts.port is None or parts.path not in ("", "/"):
            raise ValueError
        return parts, ipaddress.ip_address(parts.hostname or "")
    except ValueError:
        raise UserError(
            f"--stream {url}: expected srt://, rtp:// or udp:// with an IP address and a port, "
            "such as srt://192.168.1.30:9000"
        ) from None


def _listens(url: str) -> bool:
    parts, ip = _parts(url)
    mode = parse_qs(parts.query).get("mode", ["listener" if ip.is_unspecified else "caller"])[0]
    return bool(parts.scheme == "srt" and mode == "listener")


class StreamSender:
    """Encodes and sends the latest picture, in a thread of its own."""

    def __init__(self, options: StreamOptions) -> None:
        """Begin to send with the first picture."""
        self._options = options
        self._lock, self._ends = Lock(), Event()
        self._latest: Bytes | None = None
        self._line, self._told = "", ""
        self._thread = Thread(target=self._run, name="stream", daemon=True)
        self._thread.start()

    def show(self, picture: Bytes) -> None:
        """Send a picture (h, w, 3 or 4) from now on, top row first; sizes are even."""
        with self._lock:
            self._latest = picture

    def check(self) -> str:
        """A line if the stream began or ended since the last call, else an empty one."""
        line, self._line = self._line, ""
        return line

    def close(self) -> None:
        """Stop sending."""
        self._ends.set()
        self._thread.join(3.0)

    def _run(self) -> None:
        import av

        while not self._ends.is_set():
            if self.latest is None:
                self._ends.wait(1.0 / self._options.fps)
                continue
            try:
                self._send()
            except (av.FFmpegError, OSError, ValueError) as fault:
                waiting = self._options.listens and isinstance(fault, TimeoutError)
                self._tell("" if waiting else f"it does not arrive ({_reason(fault)})")
                self._ends.wait(AGAIN_S)

    def _send(self) -> None:
        """Send until the size of the picture changes, or the receiver is gone."""
        import av

        first = self.latest
        assert first is not None
        options, fps = self._options, self._options.fps
        height, width = first.shape[:2]
        with av.open(
            url_of(options), "w", format=FORMATS[options.scheme], options=muxing(options)
        ) as container:
            stream: Any = container.add_stream("libx264", rate=fps)
            stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
            stream.bit_rate = int(BITS * width * height * fps)
            stream.gop_size = fps  # a receiver that joins waits for a second at most
            stream.time_base = stream.codec_context.time_base = Fraction(1, fps)
            stream.options = {"preset": "veryfast", "tune": "zerolatency"}
            begun, number = time.monotonic(), 0
            while not self._ends.wait(max(begun + number / fps - time.monotonic(), 0.0)):
                picture = self.latest
                assert picture is not None
                if picture.shape[:2] != (height, width):
                    break
                frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture[..., :3]), "rgb24")
                frame.pts = number
                for packet in stream.encode(frame):
                    container.mux(packet)
                if number == fps:
                    self._tell("it arrives" if options.scheme == "srt" else "it is sent")
                # After a pause, as of the computer, pictures are left out.
                number = max(number + 1, int((time.monotonic() - begun) * fps))

    @property
    def latest(self) -> Bytes | None:
        """The picture that is sent; None before the first."""
        with self._lock:
            return self._latest

    def _tell(self, words: str) -> None:
        if words and words != self._told:
            self._told = words
            self._line = f"stream to {self._options.url}: {words}"


def url_of(options: StreamOptions) -> str:
    """The URL as FFmpeg takes it, with the time to wait for a receiver."""
    parts, ip = _parts(options.url)
    query = {key: values[0] for key, values in parse_qs(parts.query).items()}
    if options.scheme == "srt":
        latency_ms = int(query.get("latency", LATENCY_MS))
        query |= {
            "mode": "listener" if options.listens else "caller",
            "latency": str(1000 * latency_ms),
            "listen_timeout": str(WAIT_US),
            "timeout": str(WAIT_US),
            "connect_timeout": str(WAIT_US // 1000),
            "transtype": "live",
        }
    else:
        query = {"pkt_size": "1316", "ttl": str(TTL)} | query
    host = f"[{ip}]" if ip.version == 6 else str(ip)
    return f"{options.scheme}://{host}:{parts.port}?{urlencode(query)}"


def muxing(options: StreamOptions) -> dict[str, str]:
    """The options of the protocol that no URL should show."""
    return {"passphrase": options.passphrase} if options.passphrase else {}


def _reason(fault: Exception) -> str:
    return getattr(fault, "strerror", None) or str(fault)


class StreamPart(DivePart):
    """Streams a window of a dive."""

    def __init__(self, options: StreamOptions) -> None:
        """`options` say where to."""
        self._options = options
        self._sender: StreamSender | None = None
        self._small: SmallPicture | None = None
        self._output: int | None = None  # of the rig; None: the front window's
        self._source: tuple[Any, Any] | None = None  # a texture, and its framebuffer
        self._next_s = 0.0

    @staticmethod
    def add_options(parser: ArgumentParser) -> None:
        """Add the options of the stream."""
        group = parser.add_argument_group(
            "live stream", "for signage and recorders: docs/how-to/stream.md"
        )
        group.add_argument(
            "--stream",
            metavar="URL",
            help="send what a window shows there: srt://, rtp:// or udp:// ADDRESS:PORT",
        )
        group.add_argument(
            "--stream-window",
            metavar="NAME",
            help="the window of the theatre to send (default: the front one)",
        )
        group.add_argument(
            "--stream-width",
            type=int,
            metavar="PIXELS",
            help=f"the width of the stream at most (default: {WIDTH})",
        )
        group.add_argument(
            "--stream-passphrase",
            type=Path,
            metavar="FILE",
            help="file of the passphrase with which an srt:// stream is encrypted",
        )

    @classmethod
    def made(cls, options: Namespace, dive: "DiveOptions") -> "StreamPart | None":
        """Make the part for `--stream`."""
        if options.stream is None:
            names = ("stream-window", "stream-width", "stream-passphrase")
            shared.refuse(options, names, "dive: {} needs --stream")
            return None
        width = WIDTH if options.stream_width is None else options.stream_width
        if not 64 <= width <= 4096:
            raise UserError(f"--stream-width {width}: expected 64 to 4096")
        window = options.stream_window
        if window is not None and options.theatre is None:
            raise UserError("--stream-window needs --theatre")
        return cls(stream_options(options.stream, options.stream_passphrase, window, width))

    def begin(self, dive: "Dive") -> None:
        """Begin to send."""
        from subsea.stage.small_picture import SmallPicture

        names = [window.name for window in dive.window_set.windows]
        wanted = self._options.window
        if wanted is not None and wanted not in names:
            dive.note(str(unknown("window of this computer", wanted, names)))
            return
        chosen = dive.window_set.front
        if wanted is not None:
            chosen = dive.window_set.windows[names.index(wanted)]
        if chosen is not dive.window_set.front:
            self._output = names.index(chosen.name)
        self._small = SmallPicture(dive.window_set.context, self._options.width, even=True)
        self._sender = StreamSender(self._options)
        say(f"stream to {self._options.url}")

    def after(self, dive: "Dive") -> None:
        """Take a copy of the picture, as often as the stream wants one."""
        if self._small is None or self._sender is None:
            return
        if (picture := self._small.read()) is not None:
            self._sender.show(picture)
        if line := self._sender.check():
            dive.faults.say(line)
        if (now := time.monotonic()) < self._next_s:
            return
        self._next_s = now + 0.9 / self._options.fps
        if self._output is None:
            self._small.copy(dive.window_set.front.size)
            return
        texture = dive.picture.renderer.pictures[self._output, 0]
        if self._source is None or self._source[0] is not texture:
            if self._source is not None:
                self._source[1].release()
            self._source = texture, dive.window_set.context.framebuffer([texture])
            dive.window_set.context.screen.use()
        self._small.copy(texture.size, self._source[1].glo)

    def shown(self, dive: "Dive") -> None:
        """Send black while the screens are."""
        if dive.black and self._sender is not None and (last := self._sender.latest) is not None:
            self._sender.show(np.zeros_like(last))

    def close(self) -> None:
        """Stop the stream."""
        if self._sender is not None:
            self._sender.close()
            self._sender = None
        if self._small is not None:
            self._small.release()
            self._small = None
        if self._source is not None:
            self._source[1].release()
            self._source = None
