"""Environments in a window, and films of their episodes."""

import time

import av
import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import subsea.lab.environments  # noqa: F401 registers
from subsea.base.errors import UserError
from subsea.lab.environments import school
from subsea.lab.environments.showing import RecordVideo, Shown, is_filmed
from subsea.lab.environments.steered_fish import ForageEnv
from subsea.ui import glfw
from tests.support.scenes import BARE
from tests.support.windows import display_pixels, press_close_button

STILL = np.zeros(3, np.float32)
HALVES = np.zeros((60, 80, 3), np.uint8)
HALVES[:30], HALVES[30:, :40] = (250, 40, 0), (0, 60, 240)


def forage(mode):
    return ForageEnv(scenario=str(BARE), render_mode=mode, picture_size=(80, 60), max_steps=3)


def halves():
    return HALVES


def shown_pixels(shown, draw=halves):
    """Return the pixels of the display where the window is."""
    left, top = shown._window._window.position
    for _ in range(50):
        seen = display_pixels()[top : top + 60, left : left + 80]
        if seen.std() > 1.0:
            break
        shown.update(draw)
    return seen


def test_a_window_shows_the_picture_the_right_way_up(display):
    shown = Shown("human", 30.0)
    shown.update(halves)
    assert np.abs(shown_pixels(shown) - HALVES).max() < 3
    assert shown.render(halves) is None
    shown.close()
    shown.close()


def test_a_window_keeps_the_speed_of_its_environment(display):
    shown = Shown("human", 20.0)
    shown.update(halves)
    shown.update(halves)
    start = time.monotonic()
    for _ in range(6):
        shown.update(halves)
    assert 0.2 < time.monotonic() - start < 3.0
    shown.close()


def test_two_windows_and_a_window_that_is_closed(display):
    drawn = []

    def draw():
        drawn.append(1)
        return HALVES

    first, second = (Shown("human", 200.0) for _ in range(2))
    first.update(draw)
    second.update(draw)
    handle = first._window._window.handle
    press_close_button(glfw.get_x11_window(handle))
    for _ in range(100):
        first.update(draw)
        if not first._window.is_open:
            break
        time.sleep(0.02)
    assert not first._window.is_open
    count = len(drawn)
    first.update(draw)  # stays closed, and nothing is drawn for it
    assert len(drawn) == count
    second.update(draw)
    assert second._window.is_open
    first.close()
    second.close()


@pytest.mark.nightly
def test_environments_show_themselves(display):
    env = forage("human")
    env.reset(seed=1)
    assert shown_pixels(env._shown, env._draw).std() > 2.0
    assert env.render() is None
    env.step(STILL)
    env.close()
    swim = gymnasium.make("subsea/Swim-v0", render_mode="human")
    swim.reset(seed=1)
    swim.step(swim.action_space.sample())
    assert swim.unwrapped._shown._window.is_open
    swim.close()
    shoal = school.parallel_env(
        scenario=str(BARE), render_mode="human", picture_size=(80, 60), agents=[0]
    )
    shoal.reset(seed=1)
    shoal.step(dict.fromkeys(shoal.agents, STILL))
    assert shoal._shown._window.is_open
    shoal.close()


@pytest.mark.nightly
def test_the_checker_of_gymnasium_is_content(display):
    options = {"scenario": str(BARE), "picture_size": (80, 60), "render_mode": "human"}
    env = gymnasium.make("subsea/Forage-v0", **options)
    check_env(env.unwrapped, skip_render_check=False)
    env.close()


def test_without_a_display_the_alternative_is_named(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    shown = Shown("human", 30.0)
    with pytest.raises(UserError, match=r'no display .*render_mode="rgb_array" returns'):
        shown.update(halves)


def frames_of(path):
    with av.open(str(path)) as film:
        [stream] = film.streams
        return [frame.to_ndarray(format="rgb24") for frame in film.decode(stream)], stream.base_rate


def test_films_of_episodes(tmp_path):
    env = RecordVideo(forage("rgb_array"), tmp_path / "films", episode_trigger=lambda k: k != 1)
    for seed in range(3):
        env.reset(seed=seed)
        for _ in range(3):
            env.step(STILL)
    env.close()
    assert sorted(path.name for path in (tmp_path / "films").iterdir()) == [
        "rl-video-episode-0.mp4", "rl-video-episode-2.mp4",
    ]  # fmt: skip
    pictures, rate = frames_of(tmp_path / "films/rl-video-episode-0.mp4")
    assert (len(pictures), rate) == (4, 10)
    env = forage("rgb_array")
    env.reset(seed=0)
    assert np.abs(pictures[0].astype(int) - env.render()).mean() < 6.0
    env.close()


def test_films_of_a_number_of_steps_go_on_over_episodes(tmp_path):
    env = RecordVideo(
        forage("rgb_array"), tmp_path, step_trigger=lambda k: k == 1, video_length=4,
        name_prefix="swim", fps=25,
    )  # fmt: skip
    for seed in range(3):
        env.reset(seed=seed)
        for _ in range(2):
            env.step(STILL)
    env.close()
    [path] = tmp_path.iterdir()
    assert path.name == "swim-step-1.mp4"
    pictures, rate = frames_of(path)
    assert (len(pictures), rate) == (4, 25)


def test_usual_episodes_are_cubes_and_thousands():
    found = [k for k in range(3001) if is_filmed(k)]
    assert found == [0, 1, 8, 27, 64, 125, 216, 343, 512, 729, 1000, 2000, 3000]


def test_films_need_pictures_and_a_folder(tmp_path):
    with pytest.raises(ValueError, match="render_mode = None, expected 'rgb_array'"):
        RecordVideo(forage(None), tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="cannot make the folder"):
        RecordVideo(forage("rgb_array"), tmp_path / "file" / "films")
