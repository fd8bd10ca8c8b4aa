"""Full disks, killed processes, two at once: nothing is lost, and the next start works.

Every writer is a process of its own here, as a visitor starts it.
"""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import pytest
from PIL import Image

ROOT = Path(__file__).parents[1]
SMALL = 100  # bytes that a disk has room for
# What writes, the file it writes, how that is read, and how long it runs at most.
WRITERS = {
    "record": (["simulate", "--ticks", "12", "--fish", "4", "--out"], "out.h5", h5py.File),
    "picture": (["film", "--seconds", "0.1", "--size", "64x64", "--quality", "low"], "out.png",
                Image.open),
    "report": (["soak", "--minutes", "0.01", "--fish", "2", "--no-draw", "--json"], "out.json",
               lambda path: json.loads(path.read_text())),
    "repertoire": (["record", "clownfish", "--out"], "clownfish.h5", h5py.File),
}  # fmt: skip


def command(name, folder):
    """The words that make a writer write into a folder."""
    words, file, _ = WRITERS[name]
    if name == "repertoire":
        return [sys.executable, "-m", "capture", *words, str(folder)]
    return [sys.executable, "-m", "subsea", *words, str(folder / file)]


def start(words, **more):
    # Where a disk is full Python may leave a part of a module's compiled code, and trip over it.
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.Popen(
        words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=environment, **more,
    )  # fmt: skip


def no_room(size=SMALL):
    """Let this process write no file of more than a few bytes, as if the disk were full."""
    import resource

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def some_room():
    no_room(100_000)


@pytest.mark.parametrize("writer", WRITERS)
def test_a_full_disk_is_one_line_and_the_former_file_stays(writer, tmp_path):
    file = tmp_path / WRITERS[writer][1]
    file.write_text("former")
    running = start(command(writer, tmp_path), preexec_fn=no_room)
    _, err = running.communicate(timeout=250)
    assert running.returncode == 2, err
    assert "Traceback" not in err
    assert f"subsea: {file}: cannot write (File too large)" in err or writer == "repertoire"
    assert f"{tmp_path}" in err.splitlines()[-1]
    assert file.read_text() == "former"
    # Segments of a repertoire that are whole wait there for the next start.
    left = {one.name for one in tmp_path.iterdir() if one.suffix != ".recording"}
    assert left == {file.name}


def test_a_disk_that_fills_up_ends_a_long_record_at_once(tmp_path):
    """Not hours later, when all ticks are made."""
    words = ["simulate", "--ticks", "1000000", "--fish", "4", "--out", str(tmp_path / "out.h5")]
    running = start([sys.executable, "-m", "subsea", *words], preexec_fn=some_room)
    _, err = running.communicate(timeout=120)
    assert running.returncode == 2, err
    assert "out.h5: cannot write (File too large)" in err.splitlines()[-1]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("writer", ["record", "repertoire"])
def test_two_at_once_leave_one_whole_file(writer, tmp_path):
    both = [start(command(writer, tmp_path)) for _ in range(2)]
    for one in both:
        _, err = one.communicate(timeout=250)
        assert one.returncode == 0, err
    assert [one.name for one in tmp_path.iterdir()] == [WRITERS[writer][1]]
    WRITERS[writer][2](tmp_path / WRITERS[writer][1])


def test_who_is_killed_at_any_moment_loses_nothing(tmp_path):
    """A record over a former one, killed while it starts, writes, or has just written."""
    file, dice = tmp_path / "out.h5", random.Random(5)
    words = command("record", tmp_path)
    begun = time.monotonic()
    assert start(words).communicate(timeout=250) and file.exists()
    whole, took = file.read_bytes(), time.monotonic() - begun
    for _ in range(3):
        running = start(words)
        time.sleep(dice.uniform(0.3, 1.05) * took)
        running.kill()
        running.communicate()
        assert file.read_bytes() == whole
    running = start(words)
    assert running.wait(timeout=250) == 0
    assert file.read_bytes() == whole
    running.communicate()


@pytest.mark.parametrize("writer", ["picture", "report"])
@pytest.mark.skipif(not Path("/proc/1").exists(), reason="needs a folder where nobody may write")
def test_a_folder_that_is_only_read_is_one_line(writer):
    running = start([*command(writer, Path("/proc/1"))])
    _, err = running.communicate(timeout=250)
    assert running.returncode == 2, err
    assert len(err.splitlines()) <= 5
    assert "Traceback" not in err
    assert "/proc/1" in err.splitlines()[-1]
