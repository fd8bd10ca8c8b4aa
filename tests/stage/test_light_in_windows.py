"""Structured light in real windows, photographed from the display, calibrates a theatre."""

import re
import subprocess
import sys
import time
from contextlib import contextmanager

import numpy as np
import pytest

from subsea.cli.main import main as subsea
from subsea.stage.calibration.lit_theatre import lit_theatre
from subsea.stage.calibration.optics import ORDINARY
from subsea.stage.calibration.photographs import light_steps
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.screens import points_on
from subsea.view.rig import sources_at
from subsea.view.structured_light import light_picture
from tests.stage.calibration.conftest import WALL_POINTS
from tests.stage.console.conftest import Client, free_port
from tests.support.lit_room import errors_px, look, planned_room, write_points
from tests.support.scenes import BARE
from tests.support.windows import display_pixels

pytestmark = [pytest.mark.nightly, pytest.mark.timeout(1200)]
SIZE = WIDTH, HEIGHT = 160, 96
CAMERA = look((60, 30, -100), (0, 0, 400), (420, 240), ORDINARY, 290, (-0.1, 0.02), (3, -2))
LATE_S = 60.0  # a busy machine
CHANNELS = "left", "right"


def one_window(text):
    """Let both projectors be parts of one window."""
    head, channels = text.split("[[channel]]", 1)
    head = head.split("[[window]]", 1)[0]
    head += f'[[window]]\nname = "both"\nsize = [{2 * WIDTH}, {HEIGHT}]\nposition = [0, 0]\n\n'
    channels = re.sub(r'window = "\w+"', 'window = "both"', channels)
    for k, name in enumerate(CHANNELS):
        place = f"viewport = [{k * WIDTH}, 0, {WIDTH}, {HEIGHT}]"
        channels = channels.replace(f'name = "{name}"', f'name = "{name}"\n{place}')
    return f"{head}[[channel]]{channels}"


def two_computers(text):
    """Let each window be of a node of its own."""
    text = re.sub(r'(\[\[window\]\]\nname = "(\w+)")', r'\1\nnode = "\2"', text)
    address = f"127.0.0.1:{free_port()}"
    return f'{text}\n[cluster]\nmaster = "left"\naddress = "{address}"\ntimeout_s = 10\n'


@contextmanager
def dives(path, *options):
    """Run a dive for each list of options; yields the files of what they tell."""
    running, files = [], []
    try:
        for number, more in enumerate(options):
            files.append(path.with_name(f"{number}.told"))
            command = [sys.executable, "-m", "subsea", "dive", "--theatre", str(path)]
            command += ["--scenario", str(BARE), "--quality", "low", *more]
            with files[-1].open("w") as file:
                running.append(subprocess.Popen(command, stderr=file))
        yield files
    finally:
        for process in running:
            process.kill()
            process.wait()


def shown_pictures():
    """Cut a screenshot into the pictures (h, w, 3) of both projectors."""
    pixels = display_pixels()[:HEIGHT, : 2 * WIDTH]
    return [pixels[:, :WIDTH], pixels[:, WIDTH:]]


def shows(wanted, seconds=LATE_S):
    """Wait until the windows show exactly these two pictures; returns what they show."""
    end = time.monotonic() + seconds
    now = shown_pictures()
    while any((a != b).any() for a, b in zip(now, wanted, strict=True)) and time.monotonic() < end:
        time.sleep(0.05)
        now = shown_pictures()
    return now


def pictures_of(step):
    """The pattern of a step, and black."""
    pair = [np.zeros((HEIGHT, WIDTH, 3), int) for _ in CHANNELS]
    pair[step.channel] = light_picture(step.pattern, SIZE).astype(int)
    return pair


def check_calibration(path, room, taken, folder):
    """Calibrate by photographs of what windows showed: the points of both are where they lie."""
    room.photograph(CAMERA, folder / "photographs", shows=lambda number: taken[number])
    write_points(folder / "photographs/points.toml", CAMERA, WALL_POINTS)
    assert subsea(["theatre", str(path), "--calibrate", str(folder / "photographs")]) == 0
    theatre, path = load_theatre(str(path.with_name("room-calibrated.toml")))
    channels, faults = usable_channels(theatre, path)
    assert not faults
    x, y = (np.linspace(0.02, 0.98, 21) * side for side in SIZE)
    shown = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    places = np.column_stack([shown[:, 0] / WIDTH, 1 - shown[:, 1] / HEIGHT])
    for number, channel in enumerate(channels):
        points = points_on(channel.screen, sources_at(channel.warp, places))
        error = errors_px(room, number, points, shown)
        error = error[np.isfinite(error)]
        print(f"{channel.name}: {np.sqrt(np.mean(error**2)):.3f} pixels rms, {error.max():.2f}")
        assert len(error) > 0.9 * len(shown)
        assert np.sqrt(np.mean(error**2)) < 1.0


def test_two_projectors_of_one_window_by_the_key(display, user, tmp_path):
    path, room = planned_room("wall", SIZE, tmp_path, projectors=2, width=600, distance=400)
    path.write_text(one_window(path.read_text()))
    steps = light_steps(lit_theatre(str(path)).channels)
    taken = []
    with dives(path, ["--structured-light"]):
        for number, step in enumerate(steps):
            if number:
                user.do("key", "n")
            wanted = pictures_of(step)
            taken.append(shows(wanted, 300.0 if number == 0 else LATE_S))
            for got, expected in zip(taken[-1], wanted, strict=True):
                np.testing.assert_array_equal(got, expected, err_msg=f"{number}: {step.words}")
        user.do("key", "n")
        time.sleep(2.0)
        assert shown_pictures()[0].std() > 3.0  # the sea is back
    check_calibration(path, room, taken, tmp_path)


def test_a_cluster_of_two_by_the_console(display, user, tmp_path):
    path, room = planned_room("wall", SIZE, tmp_path, projectors=2, width=600, distance=400)
    path.write_text(two_computers(path.read_text()))
    steps = light_steps(lit_theatre(str(path)).channels)
    taken, port = [], free_port()
    options = [["--node", "left", "--console", f"127.0.0.1:{port}"], ["--node", "right"]]
    with dives(path, *options) as (master, _):
        end = time.monotonic() + 300.0
        while "node right: is in step" not in master.read_text():
            assert time.monotonic() < end, master.read_text()
            time.sleep(0.2)
        presenter = Client(port)
        for number, step in enumerate(steps):
            command = {"command": "structured-light", "number": number + 1}
            assert presenter.ask("/api/commands", command)[0] == 200
            wanted = pictures_of(step)
            taken.append(shows(wanted))
            for got, expected in zip(taken[-1], wanted, strict=True):
                np.testing.assert_array_equal(got, expected, err_msg=f"{number}: {step.words}")
    check_calibration(path, room, taken, tmp_path)
