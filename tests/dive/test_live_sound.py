"""Sound of a dive: settings, captions and who listens."""

import numpy as np
import pytest

from subsea.dive.live_sound import LiveSound
from subsea.dive.settings import SoundSettings
from subsea.scenario.load import load_scenario
from subsea.sound.moment import HeardSound, Moment
from subsea.sound.space import loudspeakers
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step
from tests.support.scenes import BARE


class Deaf:
    """A device that asks for nothing."""

    def __init__(self, channels, samples):
        self.channels = channels

    def close(self):
        pass


@pytest.fixture
def sound():
    lines = []
    made = LiveSound(SoundSettings(), lines.append, lines.append, open_one=Deaf)
    yield made, lines
    made.close()


def test_it_listens_to_every_tick_of_one_world(sound):
    live, _ = sound
    worlds = [create_world(load_scenario(str(BARE))[0]) for _ in range(2)]
    for world in worlds:
        live.attend(world)
        for _ in range(3):
            step(world, NEUTRAL)
    assert [len(world.observers) for world in worlds] == [0, 1]
    assert len(live._player._waiting) == 6
    live.close()
    assert worlds[1].observers == []


def test_a_ridden_fish_hears_no_motor(sound):
    live, _ = sound
    world = create_world(load_scenario(str(BARE))[0], fish=3)
    live.attend(world)
    step(world, NEUTRAL)
    live.fish = 0
    step(world, NEUTRAL)
    aboard, outside = (moment for _, moment in live._player._waiting)
    assert aboard.beds[6, 0] > 0.0  # breath
    assert outside.beds[6, 0] == 0.0


def test_volumes_are_heard_at_once_and_shown(sound):
    live, lines = sound
    live.turn(up=False)
    assert live._player.levels.volume == pytest.approx(0.7)
    live.mute()
    assert live._player.levels.mute
    live.turn(up=True)
    assert not live._player.levels.mute
    for _ in range(9):
        live.turn(up=True)
    assert live._player.levels.volume == 1.0
    assert lines[:3] == ["sound 70%", "sound off", "sound 80%"]


def test_captions_name_the_sound_and_its_side_but_not_again_and_again(sound):
    live, lines = sound
    heard = (
        HeardSound("a school passes", (-0.9, 0.0, 0.0), 0.1, 500.0),
        HeardSound("crunching", (0.8, 0.5, 0.0), 0.05, 120.0),
    )
    for tick in (1, 2, 3, 70, 71, 400):
        live._caption(moment(tick, *heard))
    assert lines == [
        "[a school passes, left]", "[crunching, right, close]", "[a school passes, left]",
    ]  # fmt: skip


def moment(tick, *heard):
    return Moment(tick, 1, np.zeros((0, 10)), np.zeros((11, 5)), heard)


def test_what_leads_comes_first_and_returns_when_it_has_come_nearer(sound):
    live, lines = sound
    school = HeardSound("a school passes", (-0.9, 0.0, 0.0), 0.5, 500.0)
    large = HeardSound("something large", (-0.9, 0.3, 0.0), 0.02, 1200.0, True)
    hush = HeardSound("the reef falls silent", (0.0, 0.0, 0.0), 0.9, 100.0, True)
    live._caption(moment(1, school, large))
    live._caption(moment(70, hush))
    live._caption(moment(240, large))  # unchanged
    live._caption(moment(260, large._replace(way=(0.9, 0.3, 0.0))))  # as far off, on another side
    live._caption(moment(310, large._replace(away=200.0, way=(0.1, 0.9, 0.0))))
    assert lines == [
        "[something large, left, far off]", "[the reef falls silent]",
        "[something large, ahead, close]",
    ]  # fmt: skip


def test_the_score_is_off_until_it_is_asked_for(sound):
    live, lines = sound
    assert live.levels.score == 0.0
    live.turn_score()
    assert live._player.levels.score == live.settings.score_level > 0.0
    live.turn_score()
    assert live._player.levels.score == 0.0
    assert lines == ["score on", "score off"]


def test_a_computer_without_loudspeakers_opens_no_device():
    def never(channels, samples):
        raise AssertionError

    live = LiveSound(SoundSettings(), print, print, loudspeakers([]), never)
    live.attend(create_world(load_scenario(str(BARE))[0]))
    step(live._world, NEUTRAL)
    live.check()
    assert len(live._player._waiting) == 0


def test_it_knows_that_the_system_has_no_device():
    def none(channels, samples):
        raise OSError("the system has no device")

    lines = []
    silent = LiveSound(SoundSettings(), lambda text: None, lines.append, open_one=none)
    assert not silent.missing  # nothing was tried yet
    silent.check()
    assert silent.missing and "no sound" in lines[0]
    unheard = LiveSound(
        SoundSettings(), lambda text: None, lines.append, loudspeakers(()), open_one=none
    )
    unheard.check()
    assert not unheard.missing  # another computer plays
