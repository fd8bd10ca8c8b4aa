"""The first minutes in a real window: the vessel glides in, the helm is handed over, prompts."""

from contextlib import closing

import numpy as np
import pytest

from subsea.dive.settings import PictureSettings, Settings
from subsea.scenario.load import load_scenario, scenario_names
from subsea.submarine.vessel import NEUTRAL, Rail, hull_axes
from subsea.ui import introduction
from subsea.ui.dive import Dive
from subsea.ui.introduction import GLIDE_S, HELM, PROMPTS, glide_in
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S
from tests.support.daily import only
from tests.support.windows import dive_options

SIZE = (320, 240)
SETTINGS = Settings(pictures=PictureSettings(logbook=False))


@pytest.fixture(scope="module")
def boat(display, user, quiet, coarse):
    options = dive_options(quiet, SIZE, coarse, introduction="full", settings=SETTINGS)
    with closing(Dive(options)) as running:
        yield running


@pytest.fixture
def begun(boat, user):
    """The introduction, from its beginning."""
    boat.introduction.end()
    boat.ride_fish(None)
    user.do("mousemove", 5, 5)
    user.glide(boat, 0.2)
    boat.introduction.begin(short=False)
    return boat.introduction


def test_a_first_dive_begins_with_it(boat):
    assert boat.introduction.active and boat.pilot.passive


def test_it_names_the_place_and_hands_over_the_helm(boat, begun, user):
    submarine, said = boat.world.state.submarine, []
    end = submarine.position.copy()
    user.glide(boat, 0.1)
    ahead = hull_axes(*submarine.angles)[0]
    assert (end - submarine.position) @ ahead > 60.0
    for _ in range(round(25.0 / 0.1)):
        boat.frame(0.1)
        if boat.caption.words and boat.caption.words not in said:
            said.append(boat.caption.words)
    assert said == [boat.scenario.title, boat.scenario.description, HELM]
    np.testing.assert_allclose(submarine.position, end, atol=2.0)
    assert not begun.active and not boat.pilot.passive and begun.prompts
    assert not boat.overlay.help_hidden or boat.overlay.help_opacity == 0.0


def test_any_key_skips_it_and_the_pointer_does_not(boat, begun, user):
    user.glide(boat, 0.5)
    user.do("mousemove", *np.add(boat.window.position, (200, 90)))
    user.glide(boat, 0.5)
    assert begun.active
    user.do("key", "b")
    user.until(boat, lambda: not begun.active)
    assert not boat.pilot.passive and boat.tick_source.steering.tour is None


@pytest.mark.nightly
def test_prompts_go_once_they_are_followed(boat, begun, user, monkeypatch):
    monkeypatch.setattr(introduction, "STEERED_S", 0.2)
    begun.skip()
    assert begun._prompt == 0
    submarine = boat.world.state.submarine
    user.until(boat, lambda: begun._opacity == 1.0)
    user.do("keydown", "d")
    user.until(boat, lambda: begun._prompt == 1)
    user.do("keyup", "d")
    user.do("keydown", "w")
    user.until(boat, lambda: begun._prompt == 2)
    user.do("keyup", "w")
    assert float(np.linalg.norm(submarine.velocity)) > 10.0
    user.do("key", "r")
    user.until(boat, lambda: begun._prompt == 3)
    user.do("key", "Escape")
    user.until(boat, lambda: begun._prompt == 4)
    user.do("key", "comma")
    user.until(boat, lambda: begun._prompt == 5)
    user.do("key", "h")
    user.until(boat, lambda: not begun.prompts)
    boat.overlay.hide_help()


def test_a_prompt_leaves_notes_free(boat, begun, user):
    begun.skip()
    user.glide(boat, 1.0)
    boat.overlay.note("a note that is as wide as the prompt")
    user.glide(boat, 0.3)
    assert begun.prompts and 0.5 * SIZE[1] < begun.area[1][1] < boat.overlay.foot
    instruments = boat.overlay.foot
    boat.overlay.note("")
    user.glide(boat, 0.3)
    assert boat.overlay.foot > instruments + 5.0


def test_a_prompt_without_an_answer_goes_by_itself(boat, begun, user, monkeypatch):
    monkeypatch.setattr(introduction, "ENOUGH_S", 0.5)
    begun.skip()
    user.glide(boat, 0.5 + 2.0 * introduction.FADE_S + 0.2)
    assert begun._prompt is not None and begun._prompt >= 1


@pytest.mark.nightly
def test_those_who_return_see_the_name_only(boat, begun, user):
    begun.end()
    begun.begin(short=True)
    assert not boat.pilot.passive
    user.glide(boat, 2.0)
    assert boat.caption.words == boat.scenario.title
    user.glide(boat, 4.0)
    assert not begun.active and not begun.prompts and not boat.caption.words


def test_each_prompt_fits_its_control():
    for prompt in PROMPTS:
        assert ("{key}" in prompt.words) == (prompt.control is not None)


@pytest.mark.nightly
@pytest.mark.parametrize("name", only(("peaceful",), scenario_names()))
def test_in_every_scenario_it_ends_where_the_dive_begins_and_meets_nothing(name):
    world = create_world(load_scenario(name)[0], fish=1)
    submarine = world.state.submarine
    end, steer = submarine.position.copy(), glide_in(world)
    places, speeds = [], []
    while world.state.tick * TICK_S < GLIDE_S + 1.0:
        rail = steer(world)
        assert isinstance(rail, Rail)
        step(world, rail)
        places.append(submarine.position.copy())
        speeds.append(float(np.linalg.norm(submarine.velocity)))
    np.testing.assert_allclose(places[-1], end, atol=1e-3)
    assert max(speeds) < 60.0 and speeds[-1] < 1.0  # slow enough to look around
    assert (np.diff(speeds[2:]) < 1e-6).all()
    step(world, NEUTRAL)
    assert np.linalg.norm(submarine.position - end) < 1.0
