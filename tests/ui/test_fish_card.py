"""The card of the fish under the pointer, in a real window."""

from contextlib import closing

import numpy as np
import pytest

from subsea.rendering.output.quality import PRESETS
from subsea.ui import fish_card
from subsea.ui.dive import Dive
from subsea.view.display_rigs import cockpit
from tests.support.windows import dive_options

SIZE = (480, 320)
FAR_CM = 80.0


@pytest.fixture(scope="module")
def boat(display, user, quiet, coarse):
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(PRESETS, "medium", PRESETS[coarse])
        with closing(Dive(dive_options(quiet, SIZE, "medium"))) as running:
            user.glide(running, 0.3)
            running.timeline.pause()
            yield running


def put(boat, user, x=0.5, y=0.4):
    """Put a fish at a place on the screen, and the pointer on it."""
    eye, way = boat.picture.front_view.ray(x, y)
    fishes = boat.world.state.fishes
    fishes.position[0] = fishes.previous_position[0] = eye + FAR_CM * way
    boat.picture.jump()
    left, top = boat.window.position
    user.do("mousemove", left + round(x * SIZE[0]), top + round(y * SIZE[1]))
    user.glide(boat, 0.3)


def test_it_appears_over_a_fish_and_goes_with_the_pointer(boat, user):
    put(boat, user)
    user.until(boat, lambda: boat.card.opacity == 1.0)
    assert boat.card.fish == 0
    left, top = boat.window.position
    user.do("mousemove", left + 10, top + SIZE[1] - 10)
    user.until(boat, lambda: boat.card.fish is None)


def test_keys_act_on_that_fish(boat, user):
    put(boat, user)
    user.until(boat, lambda: boat.card.fish == 0)
    # Another fish is nearer to the middle of the view.
    fishes = boat.world.state.fishes
    eye, way = boat.picture.front_view.ray(0.5, 0.5)
    fishes.position[1] = fishes.previous_position[1] = eye + 3.0 * FAR_CM * way
    user.do("key", "r")
    user.until(boat, lambda: boat.picture.ride is not None)
    assert boat.picture.ride.by.fish == 0
    user.glide(boat, 0.6)
    assert boat.card.fish is None  # no card on a ride
    boat.ride_fish(None)


def test_there_is_none_over_water_nor_behind_menu_and_panels(boat, user):
    put(boat, user)
    user.until(boat, lambda: boat.card.opacity == 1.0)
    boat.menu.show()
    user.glide(boat, 0.8)
    assert boat.card.fish is None
    boat.menu.hide()
    boat.world.state.fishes.position[0] = boat.world.state.fishes.previous_position[0] = cockpit(
        boat.world.state.submarine, 1.0
    ).eye - (300.0, 0.0, 0.0)
    user.glide(boat, 0.6)
    assert boat.card.fish is None


@pytest.mark.parametrize(("x", "y"), [(0.06, 0.4), (0.94, 0.9)])
def test_it_stays_in_the_picture_and_off_its_fish(boat, user, monkeypatch, x, y):
    drawn = []
    monkeypatch.setattr(fish_card, "colour", lambda rgb, alpha=1.0: (drawn.append(rgb), 0)[1])
    put(boat, user, x, y)
    user.until(boat, lambda: boat.card.opacity == 1.0)
    assert boat.card.fish == 0 and drawn
    low, high = boat.card.area
    assert low[0] >= 0.0 and high[0] <= SIZE[0] and low[1] >= 0.0 and high[1] <= boat.overlay.foot
    assert not (low[0] < x * SIZE[0] < high[0])
    assert np.isfinite([*low, *high]).all()
