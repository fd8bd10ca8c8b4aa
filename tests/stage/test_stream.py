"""A live stream that a second process receives, and places that are refused."""

import errno
import socket
import subprocess
import sys
import time
from contextlib import closing

import av
import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.stage import stream
from subsea.stage.stream import StreamPart, StreamSender, stream_options
from subsea.ui.dive import Dive
from tests.stage.console.conftest import free_port
from tests.support.scenes import BARE
from tests.support.windows import dive_options

# Prints the size of a picture, its first time stamps, and its mean colours left and right.
RECEIVER = """
import sys, time
import av
end = time.monotonic() + 60.0
while True:
    try:
        kind = "rtp" if sys.argv[2] == "rtp" else "mpegts"
        with av.open(sys.argv[1], format=kind, timeout=10.0) as container:
            frames = [frame for _, frame in zip(range(20), container.decode(video=0))]
        break
    except av.FFmpegError:
        assert time.monotonic() < end
        time.sleep(0.2)
times = [float(frame.time) for frame in frames]
picture = frames[-1].to_ndarray(format="rgb24")
half = picture.shape[1] // 2
left, right = picture[:, : half - 8], picture[:, half + 8 :]
print(*picture.shape[:2], round(max(b - a for a, b in zip(times, times[1:])), 3))
print(*left.mean(axis=(0, 1)).round(), *right.mean(axis=(0, 1)).round())
"""


def picture():
    """Red on the left, blue on the right."""
    pixels = np.zeros((96, 160, 4), np.uint8)
    pixels[:, :80, 0] = pixels[:, 80:, 2] = 200
    return pixels


@pytest.mark.nightly
@pytest.mark.parametrize("scheme", ["rtp", "udp"])
def test_a_second_process_receives_the_picture(scheme):
    port = free_port(socket.SOCK_DGRAM)
    sender = StreamSender(stream_options(f"{scheme}://127.0.0.1:{port}"))
    sender.show(picture())
    done = subprocess.run(
        [sys.executable, "-P", "-c", RECEIVER, f"{scheme}://127.0.0.1:{port}", scheme],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    line = sender.check()
    sender.close()
    assert done.returncode == 0, done.stderr
    assert line == f"stream to {scheme}://127.0.0.1:{port} is sent"
    size, colours = done.stdout.splitlines()
    assert size.split()[:2] == ["96", "160"] and float(size.split()[2]) < 1.0
    assert np.abs(np.array(colours.split(), float) - [200, 0, 0, 0, 0, 200]).max() < 12


def test_nobody_who_receives_never_holds_the_dive_up():
    sender = StreamSender(stream_options(f"udp://127.0.0.1:{free_port(socket.SOCK_DGRAM)}"))
    longest, line, end = 0.0, "", time.monotonic() + 30.0
    while not line:
        assert time.monotonic() < end
        begun = time.thread_time()
        sender.show(picture())
        line = sender.check()
        longest = max(longest, time.thread_time() - begun)
        time.sleep(0.01)
    assert line.endswith("is sent") and longest < 0.005
    sender.show(np.zeros((64, 64, 3), np.uint8))  # another size: the stream begins again
    time.sleep(0.2)
    begun = time.monotonic()
    sender.close()
    assert time.monotonic() - begun < 4.0 and sender.check() == ""


@pytest.mark.nightly
def test_a_dive_streams_its_window(display, user, coarse, capfd):
    part = StreamPart(stream_options(f"udp://127.0.0.1:{free_port(socket.SOCK_DGRAM)}", width=160))
    with closing(Dive(dive_options(BARE, (320, 240), coarse, parts=[part]))) as running:
        user.until(running, lambda: part._sender.latest is not None)
        sent = part._sender.latest[..., :3].astype(float)
        shown = running.window_set.picture().astype(float)
        shown = shown.reshape(120, 2, 160, 2, 3).mean(axis=(1, 3))
        assert sent.shape == shown.shape
        assert np.abs(sent - shown).mean() < 12.0  # the sea moves between them
        assert np.abs(sent - shown[::-1]).mean() > 12.0
        told = []
        user.until(
            running, lambda: told.append(capfd.readouterr().err) or "is sent" in "".join(told)
        )
        fault = running.faults.state
        assert fault is None or "stream" not in fault.text


def test_a_network_that_fails_is_one_line(monkeypatch):
    def fail(*given, **named):
        raise OSError(errno.ENETUNREACH, "Network is unreachable")

    monkeypatch.setattr(stream, "AGAIN_S", 0.02)
    monkeypatch.setattr(av, "open", fail)
    sender = StreamSender(stream_options("udp://10.1.1.1:9000"))
    sender.show(picture())
    end, line = time.monotonic() + 30.0, ""
    while not line:
        assert time.monotonic() < end
        time.sleep(0.01)
        line = sender.check()
    assert line == "stream to udp://10.1.1.1:9000 cannot be sent (Network is unreachable)"
    time.sleep(0.3)
    assert sender.check() == ""
    sender.close()


@pytest.mark.parametrize(
    "url",
    [
        "http://127.0.0.1:9000",
        "srt://127.0.0.1:9000",
        "udp://hall:9000",
        "udp://0.0.0.0:9000",
        "udp://127.0.0.1",
        "udp://127.0.0.1:99999",
        "udp://127.0.0.1:9000/file",
        "udp://127.0.0.1:9000?localaddr=1.2.3.4",
        "/etc/passwd",
    ],
)
def test_other_places_are_refused(url):
    with pytest.raises(UserError, match="expected rtp:// or udp:// with an IP address and a port"):
        stream_options(url)
