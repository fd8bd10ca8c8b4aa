"""The logbook of a dive in a real window: subjects that a visitor sees are entered."""

from contextlib import closing

import numpy as np
import pytest

from subsea.dive.logbook import FILE, logbook_folder
from subsea.dive.settings import PictureSettings, Settings
from subsea.dive.sightings import sightings
from subsea.rendering.output.quality import PRESETS
from subsea.scenario.storage import read_thumbnail
from subsea.ui import logbook_keeper
from subsea.ui.dive import Dive
from subsea.ui.menu import LOGBOOK, SEEN, SPECIES, VISIT
from tests.support.windows import dive_options

SIZE = (320, 240)


@pytest.fixture(scope="module")
def boat(display, user, quiet, coarse, tmp_path_factory):
    folder = tmp_path_factory.mktemp("logbook")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_DATA_HOME", str(folder))
        patch.setattr(logbook_keeper, "LOOK_S", 0.1)
        patch.setitem(PRESETS, "medium", PRESETS[coarse])
        settings = Settings(pictures=PictureSettings(folder=str(folder)))
        with closing(Dive(dive_options(quiet, SIZE, "medium", settings=settings))) as running:
            yield running


@pytest.fixture
def met(boat, user):
    """A fish before the window, in the logbook."""
    fishes, submarine = boat.world.state.fishes, boat.world.state.submarine
    user.glide(boat, 0.1)
    eye, way = boat.picture.front_view.ray(0.5, 0.5)
    submarine.velocity[:] = 0.0
    name = boat.world.species[fishes.species[0]].name

    def entered():
        place = eye + 60.0 * way
        fishes.position[0] = fishes.previous_position[0] = place
        return name in boat.logbook.book.visit

    user.until(boat, entered)
    return name


def test_a_fish_before_the_window_is_entered_with_a_picture(boat, met):
    book = boat.logbook.book
    assert book.visit[met] and book.entries[met].place == boat.scenario.title
    assert book.picture(met).is_file() and (logbook_folder() / FILE).is_file()


def test_one_behind_a_thing_is_not(boat, met, user, monkeypatch):
    monkeypatch.setattr(boat.picture, "fish_at", lambda x, y: None)
    boat.logbook.book.forget_visit()
    user.glide(boat, 1.0)
    assert not boat.logbook.book.visit


def test_the_menu_lists_what_was_met_and_hints_for_the_rest(boat, met, user):
    boat.menu.show()
    (entry,) = (one for one in boat.menu.entries() if one.text == LOGBOOK)
    assert entry.aside.startswith(f"{len(boat.logbook.book.entries)} / ")
    entry.act()
    leads = {one.text: one for one in boat.menu.entries()}
    leads[SPECIES].act()
    (fish,) = (one for one in boat.menu.entries() if one.text == met)
    assert read_thumbnail(fish.picture) is not None
    user.glide(boat, 0.3)
    boat.menu.back()
    assert boat.menu.page == LOGBOOK
    leads[SEEN].act()
    (mill,) = (one for one in boat.menu.entries() if one.text == "A mill")
    assert mill.aside == "not yet" and "circle" in mill.about
    boat.menu.hide()


def test_a_visit_ends_with_a_page_of_what_was_new(boat, met, user, tmp_path):
    boat.logbook.book.visit[met] = True
    boat.menu.show()
    (leave,) = (one for one in boat.menu.entries() if one.text == "Leave")
    leave.act()
    assert boat.menu.page == VISIT and boat.window_set.open
    save = {one.text: one for one in boat.menu.entries()}["Save as a page"]
    user.glide(boat, 0.2)
    save.act()
    assert "subsea-visit-" in boat.overlay.note_text
    boat.menu.hide()


def test_a_taken_picture_replaces_the_first(boat, met, user, monkeypatch):
    path = boat.logbook.book.picture(met)
    path.write_bytes(b"old")
    boat.run_command("picture")
    seen = {one.subject for one in sightings(boat.world, boat.picture.front_view, 1.0)}
    user.glide(boat, 0.1)
    assert met not in seen or path.read_bytes()[:2] == b"\xff\xd8"


def test_a_full_disk_is_one_line_and_the_dive_goes_on(boat, met, user, monkeypatch):
    blocked = logbook_folder() / "blocked"
    blocked.write_text("a file where a folder is expected")
    book = boat.logbook.book
    before, book.folder = book.folder, blocked
    book.forget_visit()
    user.until(boat, lambda: book.folder is None)
    assert str(blocked) in boat.faults.state.text and np.isfinite(boat.picture.alpha)
    book.folder = before
