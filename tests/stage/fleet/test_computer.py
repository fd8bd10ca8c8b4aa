"""Sensors, disk and system of computers as their folders of /sys and /etc show them."""

import time
from contextlib import closing

import pytest

from subsea.stage.fleet.computer import ComputerWatch, free_disk_gb, system_name, temperature_c


def sensor(root, name, text):
    file = root / name
    file.parent.mkdir(parents=True)
    file.write_text(text)


def test_the_hottest_plausible_sensor_counts(tmp_path):
    assert temperature_c(tmp_path) is None
    sensor(tmp_path, "class/thermal/thermal_zone0/temp", "41000\n")
    sensor(tmp_path, "class/hwmon/hwmon2/temp1_input", "63500\n")
    sensor(tmp_path, "class/hwmon/hwmon3/temp1_input", "255000\n")  # not connected
    sensor(tmp_path, "class/hwmon/hwmon4/temp1_input", "asleep\n")
    assert temperature_c(tmp_path) == 63.5


def test_the_disk_of_a_folder_that_is_missing_is_that_above_it(tmp_path):
    assert free_disk_gb(tmp_path / "not" / "yet") == pytest.approx(free_disk_gb(tmp_path), rel=0.1)


def test_the_system_has_a_name(tmp_path):
    release = tmp_path / "os-release"
    release.write_text('NAME=x\nPRETTY_NAME="Debian GNU/Linux 13 (trixie)"\n')
    assert system_name(release).startswith("Debian GNU/Linux 13 (trixie), ")
    assert system_name(tmp_path / "none") == system_name(release).partition(", ")[2]


def test_a_watch_looks_in_a_thread(tmp_path):
    with closing(ComputerWatch(tmp_path, lambda: 50.0)) as watch:
        end = time.monotonic() + 20.0
        while watch.free_disk_gb is None:
            assert time.monotonic() < end
            time.sleep(0.01)
        assert watch.temperature_c == 50.0
