"""Files that outlive a power cut."""

import os
from datetime import date, datetime, timedelta
from subprocess import run
from types import SimpleNamespace

import pytest

from subsea.base.system import state_folder
from subsea.stage.show_file import Progress, ShowClock
from subsea.stage.show_player import DiveCount, ShowScreens, ShowStore, describe_show
from subsea.world import snapshot

DAY = date(2026, 11, 26)
PROGRESS = Progress(item=3, elapsed_s=12.5, seen=datetime(2026, 11, 26, 10, 30), utc_s=1.7e9)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    return state_folder()


@pytest.fixture
def dead():
    """The number of a process that has ended."""
    return int(run(["sh", "-c", "echo $$"], capture_output=True, check=True).stdout)


def test_a_state_comes_back_for_the_same_show_only(folder):
    told = []
    store = ShowStore("this", told.append)
    assert store.load() is None
    store.save(PROGRESS, 3, lambda: b"sea")
    store.close()
    saved = ShowStore("this", told.append).load()
    assert (saved.progress, saved.shown, saved.sea) == (PROGRESS, 3, b"sea")
    assert ShowStore("another", told.append).load() is None
    assert not told and [path.name for path in folder.iterdir()] == ["show.state"]
    store.forget()
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("cut", [0.0, 0.3, 0.9])
def test_half_a_state_is_one_line(folder, cut):
    told = []
    store = ShowStore("this", told.append)
    store.save(PROGRESS, 3, lambda: b"sea" * 99)
    store.close()
    data = (folder / "show.state").read_bytes()
    (folder / "show.state").write_bytes(data[: int(cut * len(data))])
    assert store.load() is None
    assert told == [f"{folder / 'show.state'}: not the state of a show; the show begins again"]


SHOW = """
fade_s = 0.5
[[item]]
scenario = "peaceful"
for_s = 60
[[item]]
for_s = 60
"""


@pytest.fixture
def screens(tmp_path):
    """A show that is in the middle of its second item."""
    (tmp_path / "show.toml").write_text(SHOW)
    made = ShowScreens(tmp_path / "show.toml", print)
    made.player.go_to(1, 20.0)
    made.player.update(0.1)
    made.player.show_item(1)
    return made


def test_a_dive_that_starts_again_goes_on_with_its_show(screens, tmp_path, monkeypatch):
    monkeypatch.setattr(snapshot, "take", lambda world: b"sea")
    screens.end(SimpleNamespace(restarts=True, world=None))
    screens.close()
    again = ShowScreens(tmp_path / "show.toml", print)
    assert again.player.progress.item == 1 and 20.0 <= again.player.progress.elapsed_s < 30.0
    assert again._saved.sea == b"sea"
    again.end(SimpleNamespace(restarts=False, world=None))  # by the operator
    again.close()
    assert ShowScreens(tmp_path / "show.toml", print).player.progress.item == 0


def test_a_show_is_between_items_when_the_screens_are_black(screens):
    player = screens.player
    for _ in range(20):
        player.update(0.1)
    assert not screens.may_end()
    player.next_cue()
    player.update(0.1)
    assert not screens.may_end()  # they darken
    for _ in range(5):
        player.update(0.1)
    assert screens.may_end()
    player.show_item(0)
    assert not screens.may_end()


def test_a_folder_that_takes_no_file_is_one_line_and_the_show_goes_on(folder):
    folder.parent.mkdir(exist_ok=True)
    folder.write_text("a file in the place of the folder")
    told = []
    store, count = ShowStore("this", told.append), DiveCount(told.append)
    for _ in range(3):
        store.save(PROGRESS, 0, lambda: b"")
        store.close()
        count.add(DAY)
    assert count.of(DAY) == 3
    assert len(told) == 2 and all("cannot write" in line or "cannot read" in line for line in told)


def test_dives_are_counted_by_day_over_restarts(folder):
    for k in range(5):
        DiveCount(print).add(DAY + timedelta(days=k // 3))
    assert (folder / "dives.csv").read_text() == "date,dives\n2026-11-26,3\n2026-11-27,2\n"


@pytest.mark.parametrize("text", ["", "a,b\n", "date,dives\nsoon,3\n", "date,dives\n2026-11-26,x"])
def test_a_damaged_table_is_set_aside(folder, text):
    folder.mkdir(parents=True)
    (folder / "dives.csv").write_text(text)
    told = []
    count = DiveCount(told.append)
    count.add(DAY)
    assert len(told) == 1 and (folder / "dives.csv.damaged").read_text() == text
    assert (folder / "dives.csv").read_text() == "date,dives\n2026-11-26,1\n"


def test_partial_files_of_ended_processes_are_removed(folder, dead):
    folder.mkdir(parents=True)
    parts = {number: folder / f".show.state.{number}.part" for number in (dead, os.getpid())}
    for part in parts.values():
        part.write_text("half")
    others = [folder / f".{name}.part" for name in ("other.7", "show.state.x", "show.state.9.9")]
    for other in others:
        other.write_text("")
    ShowStore("this", print).load()
    assert not parts[dead].exists() and parts[os.getpid()].exists()
    assert all(other.exists() for other in others)


def test_at_night_the_evening_before_is_listed(tmp_path, monkeypatch, capsys):
    path = tmp_path / "show.toml"
    path.write_text('[hours]\nmonday = "18:00-02:00"\n[[item]]\nscenario = "peaceful"\n')
    for time, words in (
        ("2026-11-24 01:00", "open 18:00 to 02:00 yesterday"),
        ("2026-11-24 02:00", "closed today"),
        ("2026-11-23 12:00", "open 18:00 to 02:00 today"),
    ):
        at = ShowClock(datetime.fromisoformat(time), 0.0)
        monkeypatch.setattr("subsea.stage.show_file.clock_now", lambda at=at: at)
        assert describe_show(path) == 0
        assert words in capsys.readouterr().out
