"""A folder filmed in several runs equals that of a single run."""

import subprocess
import sys
import time
from functools import cache

import pytest

from subsea.cli.main import main
from subsea.dive.directed_camera import tour_steering
from subsea.dive.start import ready_world
from subsea.frame.packet import FADE, pack
from subsea.media.film import reach
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.scenario.load import load_scenario
from subsea.view.display_rigs import cockpit, display_rig
from subsea.view.levels import empty_lod_state
from subsea.view.rig import views

pytestmark = pytest.mark.usefixtures("one_context")


@cache
def begin_s():
    """A moment of the tour shortly before a fish fades from one level to another."""
    loaded = load_scenario("peaceful")
    world, preset = ready_world(loaded, 1), PRESETS["high"]
    steer, memory = tour_steering(world, "reef"), empty_lod_state(len(world.state.fishes.species))
    rig = display_rig("mono", (160, 120))
    for tenth in range(50, 600):
        alpha = reach(world, tenth / 10.0, steer, lambda: None)
        seen = views(rig, cockpit(world.state.submarine, alpha))
        packet = pack(world, seen, alpha, options=preset.packing, memory=memory)
        if tenth > 60 and (packet.instances[:, FADE] != 0.0).any():
            return tenth / 10.0 - 1.0
    raise AssertionError("no fish fades")


def film_words():
    """The arguments of the film."""
    return [
        "--size", "160x120", "--tour", "reef", "--start", str(begin_s()), "--seconds", "1.8",
        "--fps", "10", "--seed", "1",
    ]  # fmt: skip


def pictures(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*.png"))}


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """The pictures of a film from a single run, and its description."""
    out = tmp_path_factory.mktemp("whole") / "frames"
    draw, fading = Renderer.draw, []

    def watched(self, packet, *rest, **more):
        fading.append(bool((packet.instances[:, FADE] != 0.0).any()))
        return draw(self, packet, *rest, **more)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Renderer, "draw", watched)
        assert main(["film", str(out), *film_words()]) == 0
    assert sum(fading[3:]) > 1  # what was drawn before counts, or this would prove little
    return pictures(out), (out / "film.json").read_text()


@pytest.fixture
def whole(film):
    """The pictures by their names."""
    return film[0]


@pytest.mark.nightly
def test_a_film_that_was_killed_goes_on_with_the_same_pictures(tmp_path, whole, capsys):
    out = tmp_path / "frames"
    going = subprocess.Popen(
        [sys.executable, "-m", "subsea", "film", str(out), *film_words()],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    until = time.monotonic() + 200.0
    while not (out / "frame_00002.png").exists():
        assert going.poll() is None
        assert time.monotonic() < until
        time.sleep(0.01)
    going.kill()
    going.wait()
    there = pictures(out)
    assert 3 <= len(there) < len(whole)
    assert main(["film", str(out), *film_words()]) == 0
    assert f"{len(whole) - len(there)} frames" in capsys.readouterr().out
    assert pictures(out) == whole
    assert main(["film", str(out), *film_words()]) == 0
    assert "complete, 18 frames" in capsys.readouterr().out


@pytest.mark.nightly
def test_pictures_that_were_lost_are_made_again(tmp_path, film, whole):
    out = tmp_path / "frames"
    out.mkdir()
    (out / "film.json").write_text(film[1])
    for name, data in whole.items():
        (out / name).write_bytes(data)
    lost = [out / f"frame_{k:05d}.png" for k in (4, 9)]
    for path in lost:
        path.unlink()
    assert main(["film", str(out), *film_words()]) == 0
    assert pictures(out) == whole


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (["--fps", "12"], "`fps` is 10.0 there and 12.0 here"),
        (["--tour", "auto", "--seconds", "1.2"], '`tour` is "reef" there and "auto" here'),
        (["--seed", "2"], "`seed` is 1 there and 2 here"),
        (None, "`seed` is 1 there and the scenario's own here"),
        (["--size", "320x180"], "`size` is [160, 120] there and [320, 180] here"),
        (["--eye-distance", "7"], "`separation_cm` is not given there and 7.0 here"),
        (["--scenario", "visitors", "--tour", "auto"], '`scenario` is "peaceful.toml" there'),
    ],
)
def test_another_film_is_not_mixed_into_it(tmp_path, film, whole, capsys, change, told):
    out = tmp_path / "frames"
    out.mkdir()
    for name, data in whole.items():
        (out / name).write_bytes(data)
    assert main(["film", str(out), *film_words()]) == 2
    assert "unknown origin" in capsys.readouterr().err
    (out / "film.json").write_text(film[1])
    assert (
        main(["film", str(out), *(film_words()[:-2] if change is None else film_words() + change)])
        == 2
    )
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert told in error
    assert pictures(out) == whole


@pytest.mark.parametrize("text", ["", "{", "[]", "[" * 5000])
def test_a_damaged_description_is_one_line(tmp_path, capsys, text):
    out = tmp_path / "frames"
    out.mkdir()
    (out / "frame_00000.png").write_bytes(b"")
    (out / "film.json").write_text(text)
    assert main(["film", str(out), *film_words()]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "film.json: damaged" in error
    assert f"or remove {out}" in error
