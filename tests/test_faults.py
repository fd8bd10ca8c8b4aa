"""Full disks, killed processes, two writers at once: nothing is lost, the next start works.

Every writer is a separate process, as for a user, unless it ends before it writes.
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

from subsea.cli.main import main
from tests.support.daily import only

ROOT = Path(__file__).parents[1]
SMALL = 100  # bytes of free space
# Arguments of each writer, its file, and a reader of the file.
WRITERS = {
    "record": (["simulate", "--ticks", "12", "--fish", "4", "--out"], "out.h5", h5py.File),
    "picture": (["film", "--seconds", "0.1", "--size", "64x64", "--quality", "low"], "out.png",
                Image.open),
    "report": (["soak", "--minutes", "0.01", "--fish", "2", "--no-draw", "--json"], "out.json",
               lambda path: json.loads(path.read_text())),
    "repertoire": (["record", "spotted_eagle_ray", "--out"], "spotted_eagle_ray.h5", h5py.File),
}  # fmt: skip


def command(name, folder):
    """The command of a writer that writes into a folder."""
    words, file, _ = WRITERS[name]
    if name == "repertoire":
        return [sys.executable, "-m", "capture", *words, str(folder)]
    return [sys.executable, "-m", "subsea", *words, str(folder / file)]


def start(words, **more):
    # On a full disk Python may leave truncated compiled modules.
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.Popen(
        words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=environment, **more,
    )  # fmt: skip


def no_room(size=SMALL):
    """Limit the size of files that this process may write, as on a full disk."""
    import resource

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def some_room():
    no_room(100_000)


@pytest.mark.parametrize("writer", only(["record"], WRITERS))
def test_a_full_disk_is_an_error_of_one_line_and_keeps_the_old_file(writer, tmp_path):
    file = tmp_path / WRITERS[writer][1]
    file.write_text("former")
    running = start([*command(writer, tmp_path), "--force"], preexec_fn=no_room)
    _, err = running.communicate(timeout=250)
    assert running.returncode == 2, err
    assert "Traceback" not in err
    assert f"subsea: {file}: cannot write (File too large)" in err or writer == "repertoire"
    assert f"{tmp_path}" in err.splitlines()[-1]
    assert file.read_text() == "former"
    # Finished segments of a repertoire are saved for the next start.
    left = {one.name for one in tmp_path.iterdir() if one.suffix != ".recording"}
    assert left == {file.name}


@pytest.mark.nightly
def test_a_disk_that_fills_up_ends_a_long_record_at_once(tmp_path):
    """Not only at the end."""
    words = ["simulate", "--ticks", "1000000", "--fish", "4", "--out", str(tmp_path / "out.h5")]
    running = start([sys.executable, "-m", "subsea", *words], preexec_fn=some_room)
    _, err = running.communicate(timeout=120)
    assert running.returncode == 2, err
    assert "out.h5: cannot write (File too large)" in err.splitlines()[-1]
    assert not list(tmp_path.iterdir())


@pytest.mark.nightly
@pytest.mark.parametrize("writer", ["record", "repertoire"])
def test_two_writers_at_once_leave_one_whole_file(writer, tmp_path):
    both = [start(command(writer, tmp_path)) for _ in range(2)]
    for one in both:
        _, err = one.communicate(timeout=250)
        assert one.returncode == 0, err
    assert [one.name for one in tmp_path.iterdir()] == [WRITERS[writer][1]]
    WRITERS[writer][2](tmp_path / WRITERS[writer][1])


@pytest.mark.nightly
def test_a_writer_killed_at_any_moment_loses_nothing(tmp_path):
    """A record over an old one, killed while it starts, writes, or has just written."""
    file, rng = tmp_path / "out.h5", random.Random(5)
    words = command("record", tmp_path)
    begun = time.monotonic()
    assert start(words).communicate(timeout=250) and file.exists()
    whole, took = file.read_bytes(), time.monotonic() - begun
    for _ in range(3):
        running = start(words)
        time.sleep(rng.uniform(0.3, 1.05) * took)
        running.kill()
        running.communicate()
        assert file.read_bytes() == whole
    running = start(words)
    assert running.wait(timeout=250) == 0
    assert file.read_bytes() == whole
    running.communicate()


@pytest.mark.parametrize("writer", ["picture", "report"])
@pytest.mark.skipif(not Path("/proc/1").exists(), reason="needs a folder that cannot be written")
def test_a_read_only_folder_is_an_error_of_one_line(writer, capsys):
    assert main([*command(writer, Path("/proc/1"))[3:]]) == 2
    err = capsys.readouterr().err
    assert len(err.splitlines()) <= 5
    assert "/proc/1" in err.splitlines()[-1]
