"""Send what a window shows as a live stream: H.264 in an MPEG transport stream by RTP or UDP.

The dive leaves its latest picture; a thread encodes it at the stream's own rate and sends it. So
neither the network nor the encoder holds the picture up. Nothing listens here.
"""

import ipaddress
import time
from argparse import ArgumentParser, Namespace
from fractions import Fraction
from threading import Event, Lock, Thread
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import urlsplit

from subsea.base.errors import UserError, unknown
from subsea.base.progress import say
from subsea.dive import arguments as shared
from subsea.dive.part import DivePart

if TYPE_CHECKING:
    from subsea.base.arrays import Bytes
    from subsea.dive.options import DiveOptions
    from subsea.stage.small_picture import SmallPicture
    from subsea.ui.dive import Dive

FORMATS = {"rtp": "rtp_mpegts", "udp": "mpegts"}  # of FFmpeg, by scheme
FPS = 30
WIDTH = 1280  # of the stream at most, pixels
BITS = 0.1  # of a pixel in a picture
SENT = "is sent"  # ends a line that reports no fault
AGAIN_S = 2.0  # between two attempts to send
PACKET = 1316  # bytes: seven packets of a transport stream, as receivers expect
TTL = 4  # networks that a multicast packet may pass


class StreamOptions(NamedTuple):
    """The address of a stream, and the window that it shows."""

    url: str  # checked
    window: str | None = None  # of a theatre; None: the front one
    width: int = WIDTH
    fps: int = FPS

    @property
    def scheme(self) -> str:
        """The protocol: rtp or udp."""
        return urlsplit(self.url).scheme


def stream_options(url: str, window: str | None = None, width: int = WIDTH) -> StreamOptions:
    """Check the place of a stream; a UserError for anything else than an address and a port."""
    parts = urlsplit(url)
    try:
        if parts.scheme not in FORMATS or parts.port is None or parts.path not in ("", "/"):
            raise ValueError
        if parts.query or ipaddress.ip_address(parts.hostname or "").is_unspecified:
            raise ValueError
    except ValueError:
        raise UserError(
            f"--stream {url}: expected rtp:// or udp:// with an IP address and a port, such as "
            "rtp://192.168.1.30:5004"
        ) from None
    return StreamOptions(url.rstrip("/"), window, width)


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

    def show(self, picture: "Bytes") -> None:
        """Send a picture (h, w, 3 or 4) from now on, top row first; sizes are even."""
        with self._lock:
            self._latest = picture

    def check(self) -> str:
        """A line if the stream began or failed since the last call, else an empty one."""
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
            except (av.FFmpegError, OSError) as fault:
                self._tell(f"cannot be sent ({getattr(fault, 'strerror', None) or fault})")
                self._ends.wait(AGAIN_S)

    def _send(self) -> None:
        """Send until the size of the picture changes, or the network fails."""
        import av

        first = self.latest
        assert first is not None
        options, fps = self._options, self._options.fps
        height, width = first.shape[:2]
        url = f"{options.url}?pkt_size={PACKET}&ttl={TTL}"
        with av.open(url, "w", format=FORMATS[options.scheme]) as container:
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
                frame = av.VideoFrame.from_ndarray(picture[..., :3].copy("C"), "rgb24")
                frame.pts = number
                for packet in stream.encode(frame):
                    container.mux(packet)
                if number >= fps:
                    self._tell(SENT)
                # After a pause, as of the computer, pictures are left out.
                number = max(number + 1, int((time.monotonic() - begun) * fps))

    @property
    def latest(self) -> "Bytes | None":
        """The picture that is sent; None before the first."""
        with self._lock:
            return self._latest

    def _tell(self, words: str) -> None:
        if words and words != self._told:
            self._told = words
            self._line = f"stream to {self._options.url} {words}"


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
            help="send what a window shows there: rtp://ADDRESS:PORT or udp://ADDRESS:PORT",
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

    @classmethod
    def made(cls, options: Namespace, dive: "DiveOptions") -> "StreamPart | None":
        """Make the part for `--stream`."""
        if options.stream is None:
            names = ("stream-window", "stream-width")
            shared.refuse(options, names, "dive: {} needs --stream")
            return None
        width = WIDTH if options.stream_width is None else options.stream_width
        if not 64 <= width <= 4096:
            raise UserError(f"--stream-width {width}: expected 64 to 4096")
        window = options.stream_window
        if window is not None and options.theatre is None:
            raise UserError("--stream-window needs --theatre")
        return cls(stream_options(options.stream, window, width))

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
            (say if line.endswith(SENT) else dive.faults.say)(line)
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
            self._sender.show(0 * last)

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
