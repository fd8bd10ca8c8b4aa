"""A live stream that a second process receives, and places that are refused."""

import socket
import subprocess
import sys
import time

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.stage.stream import StreamSender, muxing, stream_options, url_of
from tests.stage.console.conftest import free_port

# Prints the size of a picture, its first time stamps, and its mean colours left and right.
RECEIVER = """
import sys, time
import av
end = time.monotonic() + 60.0
while True:
    try:
        with av.open(sys.argv[1], format="mpegts", timeout=10.0) as container:
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
SECRET = "a-passphrase-of-a-hall"


def picture():
    """Red on the left, blue on the right."""
    pixels = np.zeros((96, 160, 4), np.uint8)
    pixels[:, :80, 0] = pixels[:, 80:, 2] = 200
    return pixels


@pytest.fixture
def secret(tmp_path):
    file = tmp_path / "secret"
    file.write_text(f"{SECRET}\n")
    file.chmod(0o600)
    return file


@pytest.mark.parametrize("scheme", ["srt", "udp"])
def test_a_second_process_receives_the_picture(scheme, secret):
    port = free_port(socket.SOCK_DGRAM)
    mode, phrase = ("?mode=listener", secret) if scheme == "srt" else ("", None)
    sender = StreamSender(stream_options(f"{scheme}://127.0.0.1:{port}{mode}", phrase))
    sender.show(picture())
    query = f"?mode=caller&passphrase={SECRET}&timeout=5000000" if phrase else "?timeout=5000000"
    done = subprocess.run(
        [sys.executable, "-P", "-c", RECEIVER, f"{scheme}://127.0.0.1:{port}{query}"],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    sender.close()
    assert done.returncode == 0, done.stderr
    size, colours = done.stdout.splitlines()
    assert size.split()[:2] == ["96", "160"] and float(size.split()[2]) < 1.0
    assert np.abs(np.array(colours.split(), float) - [200, 0, 0, 0, 0, 200]).max() < 12


def test_a_receiver_that_is_gone_never_holds_the_dive_up():
    sender = StreamSender(stream_options(f"srt://127.0.0.1:{free_port(socket.SOCK_DGRAM)}"))
    longest, line, end = 0.0, "", time.monotonic() + 30.0
    while not line:
        assert time.monotonic() < end
        begun = time.perf_counter()
        sender.show(picture())
        line = sender.check()
        longest = max(longest, time.perf_counter() - begun)
        time.sleep(0.01)
    assert line.startswith("stream to srt://127.0.0.1:") and "it does not arrive (" in line
    assert longest < 0.2
    begun = time.monotonic()
    sender.close()
    assert time.monotonic() - begun < 4.0


def test_urls_of_ffmpeg(secret):
    listener = stream_options("srt://0.0.0.0:9000?latency=200", secret)
    assert listener.listens and listener.passphrase == SECRET
    assert "mode=listener" in url_of(listener) and "latency=200000" in url_of(listener)
    assert SECRET not in url_of(listener) and muxing(listener) == {"passphrase": SECRET}
    caller = stream_options("srt://192.168.1.9:9000")
    assert not caller.listens and "mode=caller" in url_of(caller)
    assert url_of(stream_options("rtp://239.1.1.1:5004?ttl=1")) == (
        "rtp://239.1.1.1:5004?pkt_size=1316&ttl=1"
    )
    assert url_of(stream_options("udp://[::1]:5004")).startswith("udp://[::1]:5004?")


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("http://127.0.0.1:9000", "expected srt://, rtp:// or udp://"),
        ("srt://hall:9000", "an IP address and a port"),
        ("srt://127.0.0.1", "an IP address and a port"),
        ("srt://127.0.0.1:99999", "an IP address and a port"),
        ("udp://127.0.0.1:9000/file", "an IP address and a port"),
        ("srt://127.0.0.1:9000?passphrase=abcdefghijk", "give it in --stream-passphrase FILE"),
        ("srt://0.0.0.0:9000", "other computers may call it"),
        ("srt://192.168.1.5:9000?mode=listener", "other computers may call it"),
    ],
)
def test_places_that_are_refused(url, message):
    with pytest.raises(UserError, match=message):
        stream_options(url)


def test_odd_passphrases_are_refused(tmp_path, secret):
    with pytest.raises(UserError, match="only srt:// has passphrases"):
        stream_options("udp://127.0.0.1:9000", secret)
    secret.write_text("short")
    with pytest.raises(UserError, match="10 to 79 letters"):
        stream_options("srt://127.0.0.1:9000", secret)
    secret.write_text(SECRET)
    secret.chmod(0o644)
    with pytest.raises(UserError, match="other"):
        stream_options("srt://127.0.0.1:9000", secret)
