"""Directions in a window: the camera until input, captions, rewind."""

from contextlib import closing

import numpy as np
import pytest

from subsea.dive.captions import caption_of
from subsea.dive.directed_camera import endless_tour
from subsea.dive.settings import AttractSettings, Settings
from subsea.ui.dive import Dive
from subsea.world import snapshot
from subsea.world.world import TICK_S
from tests.support.scenes import scene
from tests.support.windows import dive_options

SIZE = (480, 320)
AFTER_S = 2.0
PATIENT = Settings(attract=AttractSettings(after_min=AFTER_S / 60.0, tour="directed"))
LOOK = "look_at_cm = [-300.0, 0.0, -250.0]"
CUES = (
    f"camera = {{ position_cm = [-480.0, -200.0, -250.0], {LOOK}, over_s = 0.0 }}\n"
    "caption = 'A school of four.'\nfor_s = 1000.0",
    "at_s = 8.0\ncamera = { follow = { species = 'fusilier' }, over_s = 0.0 }\nlights = true",
)


@pytest.fixture(scope="module")
def boat(display, user, coarse, tmp_path_factory):
    file = scene(tmp_path_factory.mktemp("scene"), *CUES)
    with closing(
        Dive(dive_options(file, SIZE, coarse, settings=PATIENT, tour="directed"))
    ) as running:
        yield running


def test_it_follows_the_directed_camera_and_shows_the_caption_over_the_sea(boat, user, monkeypatch):
    user.glide(boat, 4.0)
    place = boat.world.state.submarine.position
    assert np.linalg.norm(place - (-480.0, -200.0, -250.0)) < 1.0
    assert boat.tours.timer.touring and caption_of(boat.world, 1.0).opacity == 1.0
    boat.timeline.pause()  # only the caption differs
    boat.frame(0.0)
    told = user.screen(boat)
    monkeypatch.setattr("subsea.ui.text_layer.draw_subtitle", lambda caption, rig: None)
    boat.frame(0.0)
    bare = user.screen(boat)
    differs = np.abs(told - bare).sum(axis=2) > 100
    rows, columns = np.flatnonzero(differs.any(axis=1)), np.flatnonzero(differs.any(axis=0))
    height, width = differs.shape
    assert 0.6 * height < rows.min() and rows.max() < 0.8 * height  # above the instruments
    assert (columns.min() + columns.max()) / 2 == pytest.approx(width / 2, abs=0.02 * width)
    assert told[differs].sum(axis=1).max() > 650  # light letters
    box = slice(rows.min(), rows.max() + 1), slice(columns.min(), columns.max() + 1)
    assert (told[box] < 0.6 * bare[box]).all(axis=2).mean() > 0.5  # on a dark ground
    boat.timeline.pause()


def test_after_a_rewind_the_camera_repeats_its_path(boat, user):
    user.glide(boat, 5.0)
    boat.timeline.pause()
    assert boat.world.state.submarine.lights[0]
    late = boat.world.state.tick, snapshot.checksum(boat.world)
    while boat.world.state.tick * TICK_S > 6.0:
        before = boat.world.state.tick
        user.do("key", "comma")
        user.until(boat, lambda before=before: boat.world.state.tick < before)
    assert not boat.world.state.submarine.lights[0]
    assert np.linalg.norm(boat.world.state.submarine.position - (-480.0, -200.0, -250.0)) < 1.0
    assert caption_of(boat.world, 1.0).opacity == 1.0
    boat.tours.timer.idle_s = 0.0
    boat.tick_source.set_tour(
        endless_tour(boat.world, boat.tours.name)
    )  # the key counted as input; the visitor has left again
    boat.tours.timer.begin()
    boat.timeline.pause()
    while boat.world.state.tick < late[0]:
        boat.frame(min(0.1, (late[0] - boat.world.state.tick) * TICK_S))
    assert (boat.world.state.tick, snapshot.checksum(boat.world)) == late


@pytest.mark.nightly
def test_input_takes_the_helm_and_later_the_camera_returns_smoothly(boat, user):
    user.glide(boat, 1.0)
    user.do("key", "w")
    user.until(boat, lambda: not boat.tours.timer.touring)
    assert boat.tick_source.steering.tour is None
    user.glide(boat, AFTER_S + 0.5)
    assert boat.tours.timer.touring and boat.tours.timer.shade == 0.0  # no fade to dark
    fastest, before = 0.0, boat.world.state.submarine.position.copy()
    for _ in range(60):
        boat.frame(TICK_S)
        place = boat.world.state.submarine.position
        fastest, before = max(fastest, np.linalg.norm(place - before)), place.copy()
    assert fastest < 5.0
