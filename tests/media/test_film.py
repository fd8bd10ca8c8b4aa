"""Each kind of output, small and short."""

import os
import subprocess
import sys
from fractions import Fraction
from itertools import pairwise, product
from types import SimpleNamespace

import av
import numpy as np
import pytest
from PIL import Image

from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.dive.start import picture_maker, start_world
from subsea.frame.diagrams import PlacedLabel
from subsea.frame.packet import pack
from subsea.media import eye_frames, film, frame_writers
from subsea.media import film as film_timing
from subsea.rendering.output.quality import PRESETS
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import DISPLAYS, cockpit, display_rig
from subsea.view.rig import views
from subsea.view.stereo import PAGED
from subsea.world.step import step
from subsea.world.world import TICK_S
from tests.support.daily import only
from tests.support.scenes import BARE, scene

pytestmark = pytest.mark.usefixtures("one_context")

SEA = ["--scenario", str(BARE)]  # for tests that need no full sea: a film of the bay starts slowly
SMALL = [*SEA, "--size", "161x120", "--seconds", "0.2", "--fps", "20", "--seed", "1"]


def decode(path):
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.name == "h264"
        assert stream.codec_context.pix_fmt == "yuv420p"
        assert stream.average_rate == 20
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]


def test_a_film_plays_has_even_sides_and_its_index_first(tmp_path, capsys):
    out = tmp_path / "dive.mp4"
    assert main(["film", str(out), *SMALL]) == 0
    pictures = decode(out)
    assert len(pictures) == 4
    assert pictures[0].shape == (120, 160, 3)
    assert pictures[0].std() > 3.0  # not a blank picture
    data = out.read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")
    assert [path.name for path in tmp_path.iterdir()] == ["dive.mp4"]
    assert "4 frames; frame time in ms: mean" in capsys.readouterr().out


def test_a_folder_gets_numbered_pictures_and_the_film_moves(tmp_path):
    out = tmp_path / "frames"
    assert main(["film", str(out), *SMALL]) == 0
    names = sorted(path.name for path in out.iterdir())
    assert names == ["film.json", *(f"frame_{k:05d}.png" for k in range(4))]
    first, last = (np.asarray(Image.open(out / names[k])).astype(int) for k in (1, 4))
    assert first.shape == (120, 161, 3)
    assert np.abs(first - last).max() > 8


def test_diagrams_and_numbers_are_on_a_film_and_another_list_is_another_film(tmp_path, capsys):
    bare, shown = tmp_path / "bare.png", tmp_path / "shown"
    assert main(["film", str(bare), *SMALL, "--seconds", "0.05"]) == 0
    lines = ["--show", "school,bounds,indices", "--fps", "10", "--seconds", "0.1"]
    assert main(["film", str(shown), *SMALL, *lines]) == 0
    one, other = (np.asarray(Image.open(path)) for path in (bare, shown / "frame_00000.png"))
    changed = np.abs(one.astype(int) - other).max(axis=2) > 60
    assert 0.01 < changed.mean() < 0.5
    assert main(["film", str(shown), *SMALL, *lines, "--wireframe"]) == 2
    assert "`wireframe` is false there and true" in capsys.readouterr().err
    assert main(["film", str(tmp_path / "no.png"), *SMALL, "--show", "scafold"]) == 2
    assert "did you mean 'scaffold'" in capsys.readouterr().err


@pytest.mark.nightly
def test_a_fish_is_filmed_from_behind(tmp_path, capsys):
    out = tmp_path / "fish.png"
    options = [*SMALL, "--seconds", "1", "--quality", "low"]
    assert main(["film", str(out), *options, "--follow", "clownfish"]) == 0
    picture = np.asarray(Image.open(out)).astype(int)
    height, width, _ = picture.shape
    middle = picture[height // 3 : 2 * height // 3, 2 * width // 5 : 3 * width // 5]
    orange = (middle[..., 0] > 150) & (middle[..., 0] > middle[..., 2] + 60)
    assert orange.mean() > 0.004  # visible, in the middle, from behind
    capsys.readouterr()
    assert main(["film", str(out), *options, "--follow", "clownfsh"]) == 2
    assert "clownfish" in capsys.readouterr().err
    more = ["--follow", "clownfish", "--eyes", "0"]
    assert main(["film", str(tmp_path / "seen"), *SMALL, *more]) == 2
    assert "--follow" in capsys.readouterr().err


def test_labels_stand_above_their_places_on_the_picture_that_they_are_for():
    plain = np.full((800, 300, 3), 90, np.uint8)
    words = [PlacedLabel(0, 150.0, 100.0, "17"), PlacedLabel(1, 20.0, 20.0, "8")]
    picture = film.lettered(plain, words, 0)
    rows, columns = np.nonzero((picture > 200).all(axis=2))
    assert len(rows) > 5
    assert 80 < rows.min() < rows.max() <= 101
    assert abs(columns.mean() - 150) < 4
    assert film.lettered(plain, words, 2) is plain


@pytest.mark.nightly
def test_a_picture_is_the_same_each_time(tmp_path):
    one, two = tmp_path / "one.png", tmp_path / "two.png"
    for out in (one, two):
        assert main(["film", str(out), *SMALL]) == 0
    assert np.asarray(Image.open(one)).shape == (120, 161, 3)
    assert one.read_bytes() == two.read_bytes()


def test_a_film_for_shutter_glasses_is_one_line_with_other_modes(tmp_path, capsys):
    assert main(["film", str(tmp_path / "a.png"), "--display", "stereo"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "side-by-side" in error
    assert not list(tmp_path.iterdir())


@pytest.mark.nightly
def test_the_eyes_are_set_by_options(tmp_path):
    pictures = {}
    for option in ("", "--swap-eyes", "--eye-distance=30", "--screen-distance=400"):
        arguments = [*SEA, "--display", "checkerboard", "--size", "64x64", "--seconds", "0.1"]
        assert main(["film", str(tmp_path / "a.png"), *arguments, *filter(None, [option])]) == 0
        pictures[option] = np.asarray(Image.open(tmp_path / "a.png")).tobytes()
    assert len(set(pictures.values())) == len(pictures)


@pytest.mark.parametrize("display", ["side-by-side", "top-bottom"])
def test_stereo_shows_two_different_eyes(tmp_path, display):
    out = tmp_path / "stereo.png"
    arguments = [*SEA, "--display", display, "--size", "160x120", "--seconds", "1"]
    assert main(["film", str(out), *arguments]) == 0
    picture = np.asarray(Image.open(out)).astype(int)
    axis = 1 if display == "side-by-side" else 0
    left, right = np.split(picture, 2, axis=axis)
    assert np.abs(left - right).max() > 4
    assert abs(left.mean() - right.mean()) < 10.0


def test_too_old_an_opengl_is_one_line_with_what_to_install(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "subsea", "film", str(tmp_path / "a.png"), *SMALL],
        env=os.environ | {"MESA_GL_VERSION_OVERRIDE": "2.1"},
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "no OpenGL 3.3" in done.stderr
    assert "apt-get install" in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("fault", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_only_written_files_are_reported(tmp_path, capsys, monkeypatch, fault):
    def failing(*arguments, **options):
        raise fault

    monkeypatch.setattr(Image.Image, "save", failing)
    assert main(["film", str(tmp_path / "new" / "a.png"), *SMALL]) in (75, 130)
    assert not capsys.readouterr().out
    assert not list(tmp_path.iterdir())


def test_an_interrupted_film_reports_its_frames(tmp_path, capsys, monkeypatch):
    pictures = [np.full((120, 160, 3), level, np.uint8) for level in (0, 50)]

    def two(self, output=0):
        if not pictures:
            raise KeyboardInterrupt
        return pictures.pop()

    monkeypatch.setattr("subsea.rendering.renderer.Renderer.read_pixels", two)
    out = tmp_path / "a.mp4"
    assert main(["film", str(out), *SMALL]) == 130
    assert f"{out}: 2 frames" in capsys.readouterr().out
    assert len(decode(out)) == 2


def open_one(out):
    return frame_writers.open_writers(out, {"": (64, 48)}, frame_writers.FilmFormat(Fraction(20)))


def grey(level):
    return np.full((48, 64, 3), level, np.uint8)


def test_an_interruption_leaves_a_valid_shorter_film(tmp_path):
    out = tmp_path / "dive.mp4"
    with pytest.raises(KeyboardInterrupt), open_one(out) as write:
        for k, level in enumerate(range(0, 100, 20)):
            write(k, {"": grey(level)})
        raise KeyboardInterrupt
    assert len(decode(out)) == 5
    assert [path.name for path in tmp_path.iterdir()] == ["dive.mp4"]


@pytest.mark.parametrize("fault", [RuntimeError, KeyboardInterrupt])
def test_a_fault_or_an_interruption_before_the_first_picture_leaves_nothing(tmp_path, fault):
    with pytest.raises(fault), open_one(tmp_path / "dive.mp4"):
        raise fault
    assert not list(tmp_path.iterdir())


def test_the_same_pictures_make_the_same_film(tmp_path):
    dice = np.random.default_rng(1)
    pictures = [np.kron(dice.integers(0, 255, (15, 20, 3)), np.ones((8, 8, 1))) for _ in range(40)]
    films = set()
    for k in range(4):
        out = tmp_path / f"{k}.mp4"
        with frame_writers.open_writers(
            out, {"": (160, 120)}, frame_writers.FilmFormat(Fraction(20))
        ) as write:
            for number, picture in enumerate(pictures):
                write(number, {"": picture.astype(np.uint8)})
        films.add(out.read_bytes())
    assert len(films) == 1


def test_the_name_decides(tmp_path):
    assert frame_writers.kind_of(tmp_path / "a.MP4") == "film"
    assert frame_writers.kind_of(tmp_path / "a.png") == "picture"
    assert frame_writers.kind_of(tmp_path / "a") == "folder"
    with pytest.raises(UserError, match=r"\.gif"):
        frame_writers.kind_of(tmp_path / "a.gif")
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="cannot write there"):
        frame_writers.check_output(tmp_path / "file" / "a.mp4")


@pytest.mark.parametrize("name", ["dive.mp4", "dive"])
def test_each_window_of_a_theatre_has_an_output_of_its_own(tmp_path, name):
    out = tmp_path / name
    sizes = {"left": (64, 48), "right": (32, 48)}
    with frame_writers.open_writers(out, sizes, frame_writers.FilmFormat(Fraction(20))) as write:
        for k in range(3):
            write(k, {"left": grey(20 * k), "right": grey(100)[:, :32]})
    if name == "dive":
        shapes = {p: np.asarray(Image.open(out / p / "frame_00002.png")).shape for p in sizes}
    else:
        shapes = {p: decode(tmp_path / f"dive-{p}.mp4")[2].shape for p in sizes}
    assert shapes == {"left": (48, 64, 3), "right": (48, 32, 3)}


RATES = ("mono", 29.97), ("side-by-side", 24), ("checkerboard", 25), ("dome", 50)


def test_television_rates_are_exact(tmp_path):
    rates = {
        fps: frame_writers.frame_rate(fps) for fps in (1.0, 24.0, 25.0, 23.976, 29.97, 50.0, 59.94)
    }
    assert rates == {
        1.0: 1, 24.0: 24, 25.0: 25, 23.976: Fraction(24000, 1001), 29.97: Fraction(30000, 1001),
        50.0: 50, 59.94: Fraction(60000, 1001),
    }  # fmt: skip
    assert frame_writers.frame_rate(12.5) == Fraction(25, 2)


@pytest.mark.parametrize(
    ("display", "fps"),
    only(RATES[:1], RATES),
)
def test_the_same_command_gives_the_same_film(tmp_path, display, fps):
    arguments = [*SEA, "--display", display, "--size", "64x64", "--seconds", "0.1", "--seed", "1"]
    films = []
    for name in ("one.mp4", "two.mp4"):
        assert main(["film", str(tmp_path / name), *arguments, "--fps", str(fps)]) == 0
        with av.open(str(tmp_path / name)) as container:
            assert container.streams.video[0].average_rate == frame_writers.frame_rate(fps)
            films.append([frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)])
    np.testing.assert_array_equal(*films)
    assert len(films[0]) == round(0.1 * fps) > 1
    assert (films[0][0] != films[0][-1]).any()


def every_mode():
    """A picture of a separate dive in each quality and display of films."""
    pictures = {}
    rigs = {name: display_rig(name, (48, 48)) for name in DISPLAYS if name != PAGED}
    with film.headless() as context:
        world = start_world("peaceful", 1)
        with picture_maker(context, world, rigs["mono"], PRESETS["medium"]) as renderer:
            while world.state.tick < 10:
                step(world, NEUTRAL)
            for (quality, preset), (display, rig) in product(PRESETS.items(), rigs.items()):
                renderer.adapt(preset)
                renderer.arrange(rig)
                seen = views(rig, cockpit(world.state.submarine, 0.5))
                renderer.draw(pack(world, seen, 0.5, options=preset.packing))
                pictures[quality, display] = renderer.read_pixels().tobytes()
    return pictures


@pytest.mark.nightly
def test_two_dives_show_the_same_in_every_quality_and_display():
    pictures = every_mode()
    assert len(set(pictures.values())) == len(pictures) == len(PRESETS) * (len(DISPLAYS) - 1)
    assert every_mode() == pictures


def test_a_tour_of_the_scenario_is_filmed_to_its_end(tmp_path, capsys):
    place = [f"position_cm = [{x}, -60, -330]" for x in (-460, -430)]
    file = tmp_path / "s.toml"
    file.write_text(
        BARE.read_text()
        + '[[tour]]\nname = "short"\nwaypoint = [{time_s = 0, look_at_cm = [-460, 700, -330], '
        + f"{place[0]}}}, {{time_s = 0.6, {place[1]}}}]\n"
    )
    arguments = ["--scenario", str(file), "--size", "64x64", "--fps", "5", "--seed", "1"]
    shown = {}
    for tour in ("short", "auto"):
        out = tmp_path / tour
        rest = ["--tour", tour] if tour == "short" else ["--seconds", "0.6"]
        assert main(["film", str(out), *arguments, *rest]) == 0
        shown[tour] = [np.asarray(Image.open(path)) for path in sorted(out.glob("*.png"))]
    assert len(shown["short"]) == 3
    assert (shown["short"][0] != shown["auto"][0]).mean() > 0.5  # it starts elsewhere
    assert (
        main(["film", str(tmp_path / "auto"), *arguments, "--seconds", "0.6", "--tour", "sh"]) == 2
    )
    assert "did you mean 'short'" in capsys.readouterr().err


@pytest.mark.nightly
def test_directions_are_filmed_with_their_captions_until_they_are_over(tmp_path, capsys):
    there = "position_cm = [{}, -60.0, -250.0], look_at_cm = [-300.0, 0.0, -250.0], over_s = 0.0"
    file = scene(
        tmp_path,
        f"camera = {{ {there.format(-480.0)} }}\ncaption = 'Here they are.'\nfor_s = 4.0",
        f"at_s = 0.6\ncamera = {{ {there.format(-150.0)} }}",
        "at_s = 1.0\nend = true",
    )
    arguments = ["--scenario", str(file), "--size", "96x64", "--fps", "5", "--tour", "directed"]
    assert main(["film", str(tmp_path / "all"), *arguments]) == 0
    assert "rehearsing the directions" in capsys.readouterr().err
    shown = sorted((tmp_path / "all").glob("*.png"))
    pictures = [np.asarray(Image.open(path)).astype(int) for path in shown]
    assert len(pictures) == 5
    changes = [np.abs(b - a).mean() for a, b in pairwise(pictures)]
    assert np.argmax(changes) == 3 and changes[3] > 2.0 * max(changes[:3])  # the cut, at 0.63 s
    silent = file.with_name("silent.toml")
    silent.write_text(file.read_text().replace("caption = 'Here they are.'", ""))
    arguments[1] = str(silent)
    assert main(["film", str(tmp_path / "silent"), *arguments]) == 0
    other = np.asarray(Image.open(tmp_path / "silent" / shown[3].name)).astype(int)
    rows = np.flatnonzero(np.abs(pictures[3] - other).sum(axis=2).max(axis=1) > 150)
    assert len(rows) and rows.min() > 0.6 * 64
    assert main(["film", str(tmp_path / "x"), "--tour", "directed"]) == 2
    assert "has a `camera`" in capsys.readouterr().err


def test_a_film_may_begin_later(tmp_path):
    arguments = [*SEA, "--size", "64x64", "--fps", "5", "--seed", "1"]
    assert main(["film", str(tmp_path / "all"), "--seconds", "1", *arguments]) == 0
    late = [str(tmp_path / "late"), "--start", "0.6", "--seconds", "0.4"]
    assert main(["film", *late, *arguments]) == 0
    for k in range(2):
        one = np.asarray(Image.open(tmp_path / "all" / f"frame_{k + 3:05d}.png")).astype(int)
        two = np.asarray(Image.open(tmp_path / "late" / f"frame_{k:05d}.png")).astype(int)
        assert np.abs(one - two).mean() < 0.2  # except fishes that change their level of detail


@pytest.mark.parametrize(
    ("module", "more"),
    [(film, []), pytest.param(eye_frames, ["--eyes", "0"], marks=pytest.mark.nightly)],
)
def test_frame_times_exclude_ticks_before_the_film(tmp_path, monkeypatch, module, more):
    made, told = [], []

    def counted(*arguments):
        made.append(1)
        step(*arguments)

    monkeypatch.setattr(film_timing, "step", counted)
    monkeypatch.setattr(module, "time", SimpleNamespace(perf_counter=lambda: len(made)))
    monkeypatch.setattr(
        module, "describe_durations", lambda durations: told.extend(durations) or ""
    )
    arguments = [str(tmp_path / "later"), *SEA, "--size", "64x64", "--fps", "10"]
    assert main(["film", *arguments, "--start", "1.5", "--seconds", "0.5", *more]) == 0
    assert len(made) > 45
    assert told[0] == 0
    assert set(told[1:]) <= {3, 4}


def test_a_world_is_reached_when_the_instant_lies_between_its_last_two_ticks(monkeypatch):
    state, told = SimpleNamespace(tick=1), []

    def tick(world, helm):
        assert told[-1] == helm == world.state.tick
        world.state.tick += 1

    monkeypatch.setattr(film_timing, "step", tick)
    for instant in (0.0, 0.02, 0.5, 0.5, 1.7):
        alpha = film_timing.reach(
            SimpleNamespace(state=state), instant, lambda world: world.state.tick,
            lambda: None, lambda: told.append(state.tick),
        )  # fmt: skip
        assert 0.0 <= alpha < 1.0
        assert (state.tick - 1 + alpha) * TICK_S == pytest.approx(instant)
    assert told == list(range(1, state.tick))


@pytest.mark.nightly
def test_a_theatre_is_filmed_into_an_output_for_each_window(tmp_path, monkeypatch, capsys):
    """The windows of a theatre together equal a single one, each in its own file."""
    out = tmp_path / "wall.png"
    options = ["--seconds", "0.1", "--quality", "low", "--shrink", "16"]
    assert main(["film", str(out), "--theatre", "cave", *options]) == 0
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["wall-front.png", "wall-left.png", "wall-right.png"]
    told = capsys.readouterr()
    [done] = [line for line in told.out.splitlines() if line.endswith(": written")]
    [begun] = [line for line in told.err.splitlines() if "filming to" in line]
    for line in (done.removesuffix(": written"), begun.partition("filming to ")[2]):
        assert sorted(line.split(", ")) == [str(tmp_path / name) for name in names]
    pictures = {name: np.asarray(Image.open(tmp_path / name)) for name in names}
    assert {picture.shape for picture in pictures.values()} == {(64, 64, 3)}
    assert all(picture.std() > 5 for picture in pictures.values())
    # The edge that two walls share looks alike on both, as columns side by side on one do.
    left, front = pictures["wall-left.png"].astype(float), pictures["wall-front.png"].astype(float)
    seam, inside = left[:, -1] - front[:, 0], left[:, -2] - left[:, -1]
    assert np.abs(seam).mean() < 1.2 * np.abs(inside).mean()
    assert np.abs(left[:, 0] - front[:, 0]).mean() > 1.5 * np.abs(inside).mean()
    folder = tmp_path / "frames"
    again = ["film", str(folder), "--theatre", "cave", "--fps", "20", *options]
    assert main(again) == 0
    assert (folder / "front" / "frame_00001.png").exists()
    capsys.readouterr()
    assert main(again) == 0
    assert "complete, 2 frames" in capsys.readouterr().out
