"""Labelled frames of a fish's view, used as in vision research."""

import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.dive.ride import VALUES, coded, retina_brightness
from subsea.dive.start import headless, picture_maker
from subsea.geometry.rotation import from_matrix
from subsea.media import eye_frames as eyes
from subsea.rendering.output.quality import PRESETS
from subsea.scenario.load import load_scenario
from subsea.scenario.shoals import find_fish
from subsea.submarine.vessel import NEUTRAL
from subsea.view.retina import fish_eyes, retina_rig
from subsea.world.build import create_world
from subsea.world.step import step

pytestmark = pytest.mark.usefixtures("one_context")

DOCS = Path(__file__).parents[2] / "docs" / "how-to" / "fish-frames.md"
FISH = 57
OPTIONS = ["--eyes", "moon_wrasse", "--size", "96x72", "--quality", "low", "--fps", "5"]
COUNT = 3


def film(out, *more, seconds="0.6"):
    return main(["film", str(out), *OPTIONS, "--seconds", seconds, *more])


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    """A folder called `seen`, and what its camera file says."""
    out = tmp_path_factory.mktemp("film") / "seen"
    assert film(out) == 0
    return SimpleNamespace(out=out, about=json.loads((out / "camera.json").read_text()))


def picture(seen, name, frame=0):
    return np.asarray(Image.open(seen.out / name / f"frame_{frame:05d}.png"))


def files(out):
    return {str(path.relative_to(out)): path.read_bytes() for path in out.rglob("*.*")}


def copied(seen, out):
    for name, data in files(seen.out).items():
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).write_bytes(data)


def test_every_frame_has_pictures_and_maps_of_both_eyes(seen):
    for frame in range(COUNT):
        for side in ("left", "right"):
            assert picture(seen, side, frame).shape == (72, 96, 3)
            assert picture(seen, f"coded/{side}", frame).shape == (72, 96, 3)
            for name in ("identity", "depth"):
                found = picture(seen, f"{name}/{side}", frame)
                assert found.shape == (72, 96)
                assert found.dtype == np.uint16
    assert len(files(seen.out)) == 8 * COUNT + 2
    assert [one["frame"] for one in seen.about["frames"]] == list(range(COUNT))
    assert [one["time_s"] for one in seen.about["frames"]] == [0.0, 0.2, 0.4]
    times = [0.033 * (one["tick"] + one["between"]) for one in seen.about["frames"]]
    assert times == pytest.approx([0.0, 0.2, 0.4])  # where the bodies of the picture are
    assert [one["tick"] for one in seen.about["frames"]] == [0, 6, 12]


def test_every_identity_is_in_the_table_and_its_own_is_not_in_the_maps(seen):
    table = {one["value"]: one for one in seen.about["identities"]}
    assert len(table) == len(seen.about["identities"])
    values = set(np.unique([picture(seen, "identity/left", k) for k in range(COUNT)]).tolist())
    assert values <= set(table)
    assert {table[value]["kind"] for value in values} >= {"water", "seabed", "rock"}
    assert VALUES["fish"] + FISH not in values
    assert table[VALUES["fish"] + FISH]["species"] == "moon_wrasse"
    depth, identity = picture(seen, "depth/left"), picture(seen, "identity/left")
    np.testing.assert_array_equal(depth == 0, identity == 0)


def test_the_example_of_the_documentation_makes_the_cloud_that_it_says(seen, monkeypatch):
    """Both eyes place the same things at the same points."""
    (code,) = re.findall(r"```python\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    monkeypatch.chdir(seen.out.parent)
    left, right = {}, {}
    exec(code, left)
    exec(code.replace("left", "right"), right)
    assert left["points"].shape[1] == 3
    sand = left["points"][left["labels"] == VALUES["seabed"]]
    assert len(sand) > 300
    assert np.ptp(sand[:, 2]) < 0.5 * np.ptp(sand[:, :2])
    # Project the left eye's points into the right eye's picture.
    camera = seen.about["camera"]
    x, y, z, _ = np.array(left["frame"]["right"]) @ np.c_[left["points"], np.ones(len(left["z"]))].T
    column = np.rint(camera["fx"] * x / z + camera["cx"]).astype(int)
    row = np.rint(camera["fy"] * y / z + camera["cy"]).astype(int)
    inside = (column >= 0) & (column < 96) & (row >= 0) & (row < 72)
    found = right["identity"][row[inside], column[inside]]
    nearer = right["depth"][row[inside], column[inside]] < z[inside] - 1.0
    assert inside.mean() > 0.8
    assert ((found == left["labels"][inside]) | nearer).mean() > 0.97
    # The eyes are as far apart as is said, and the fish lies between and behind them.
    eyes = [np.linalg.inv(left["frame"][side])[:3, 3] for side in ("left", "right")]
    assert np.linalg.norm(eyes[1] - eyes[0]) == pytest.approx(camera["baseline_cm"], rel=1e-4)
    assert np.linalg.norm(np.mean(eyes, axis=0) - left["frame"]["fish"]["position_cm"]) < 15.0


@pytest.mark.nightly
def test_an_interrupted_film_resumes_with_the_same_pictures(seen, tmp_path, capsys):
    out = tmp_path / "seen"
    copied(seen, out)
    for name in ("camera.json", "depth/right/frame_00001.png", "left/frame_00002.png"):
        (out / name).unlink()
    assert film(out) == 0
    assert files(out) == files(seen.out)
    capsys.readouterr()
    assert film(out) == 0
    assert "complete" in capsys.readouterr().out
    assert film(out, "--gaze=20,0") == 2
    assert "`gaze`" in capsys.readouterr().err


@pytest.mark.nightly
def test_an_interrupted_second_run_keeps_the_camera_file(seen, tmp_path, monkeypatch):
    out = tmp_path / "seen"
    copied(seen, out)
    (out / "left/frame_00001.png").unlink()

    def interrupted(*given):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(eyes, "labelled", interrupted)
        assert film(out) == 130
    about = (out / "camera.json").read_text()
    assert about == (seen.out / "camera.json").read_text()
    # Nor is another film's file accepted.
    (out / "camera.json").write_text(about.replace('"fps": 5.0', '"fps": 7.0'))
    assert film(out) == 0
    assert files(out) == files(seen.out)


def test_a_film_of_another_kind_is_not_mixed_into_it(seen, tmp_path, capsys):
    out = tmp_path / "seen"
    copied(seen, out)
    assert main(["film", str(out), "--size", "96x72", "--seconds", "0.6"]) == 2
    assert "holds another film" in capsys.readouterr().err
    assert files(out) == files(seen.out)
    plain = tmp_path / "plain"
    plain.mkdir()
    (plain / "frame_00000.png").write_bytes(b"")
    (plain / "film.json").write_text('{"display": "mono"}')
    assert film(plain) == 2
    assert "holds another film" in capsys.readouterr().err
    assert len(files(plain)) == 2


@pytest.mark.parametrize("name", ["9999", "clownfish:99", "clownfish:2"])
def test_a_fish_that_is_not_there_is_refused_before_the_sea_is_made(
    tmp_path, capsys, monkeypatch, name
):
    def made(*arguments, **options):
        raise AssertionError

    monkeypatch.setattr("subsea.media.eye_frames.ready_world", made)
    monkeypatch.setattr("subsea.media.eye_frames.headless", made)
    assert main(["film", str(tmp_path / "out"), "--eyes", name]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert "expected 0 to " in line


def test_fishes_are_called_as_the_world_numbers_them(seen):
    scenario, counts = load_scenario("peaceful")[0], {}
    fishes = [one for one in seen.about["identities"] if one["kind"] == "fish"]
    for one in fishes:
        count = counts[one["species"]] = counts.get(one["species"], -1) + 1
        assert find_fish(f"{one['species']}:{count}", scenario) == one["number"]
        assert find_fish(str(one["number"]), scenario) == one["number"]
    assert len(counts) > 2
    with pytest.raises(UserError, match=f"expected 0 to {len(fishes) - 1}"):
        find_fish(str(len(fishes)), scenario)


BAD_INPUT = [
    ("out", ["--eyes", "whale"], "whale"),
    ("out", ["--eyes", "100000"], "0 to "),
    ("out", ["--eyes", "clownfish:9"], "0 to 1"),
    ("out", ["--eyes", "clownfish:x"], "SPECIES:NUMBER"),
    ("out.mp4", ["--eyes", "0"], "folder"),
    ("out", ["--eyes", "0", "--display", "dome"], "dome"),
    ("out", ["--eyes", "0", "--theatre", "cave"], "not --theatre"),
    ("out", ["--eyes", "0", "--shrink", "2"], "not --shrink"),
    ("out", ["--eyes", "0", "--swap-eyes"], "not --swap-eyes"),
    ("out", ["--eyes", "0", "--eye-distance", "0"], "not --eye-distance"),
    ("out", ["--eyes", "0", "--comfort", "1"], "not --comfort"),
    ("out", ["--eyes", "0", "--dome-tilt", "0"], "not --dome-tilt"),
    ("out", ["--eyes", "0", "--gaze", "a,b"], "gaze"),
    ("out", ["--eyes", "0", "--gaze", "0,95"], "range"),
    ("out", ["--gaze", "0,5"], "--eyes"),
]


def test_bad_input_is_one_line_and_leaves_nothing(tmp_path, capsys):
    for name, arguments, says in BAD_INPUT:
        assert main(["film", str(tmp_path / name), *arguments]) == 2
        last = capsys.readouterr().err.splitlines()[-1]
        assert last.startswith("subsea: ")
        assert says in last, arguments
        assert not list(tmp_path.iterdir())


def test_fishes_are_red_and_solids_are_blue():
    fishes = coded(VALUES["fish"] + np.arange(500)[None])[0].astype(int)
    stones = coded(
        np.concatenate([VALUES["rock"] + np.arange(60), VALUES["coral"] + np.arange(300)])
    )
    assert (fishes[:, 0] > 1.5 * fishes[:, 1:].max(axis=1)).all()
    assert (stones[:, 2] > stones[:, :2].astype(int).max(axis=1)).all()
    assert len(np.unique(fishes, axis=0)) > 450


@pytest.mark.nightly
def test_light_in_the_eyes_replaces_that_of_the_place():
    world = create_world(load_scenario("peaceful")[0], fish=12)
    other = create_world(load_scenario("peaceful")[0], fish=12)
    fishes, by = world.state.fishes, fish_eyes(world, 2)
    means = []
    with headless() as context:
        rig = retina_rig((64, 64), by.half_cm)
        with picture_maker(context, world, rig, PRESETS["low"]) as renderer:
            fishes.position[2, 2] = fishes.previous_position[2, 2] = -150.0
            for pitch in (1.2, -1.2):  # up toward the sky, down toward the sand
                c, s = np.cos(pitch), np.sin(pitch)
                axes = np.array([[[c, -s, 0.0], [0.0, 0.0, -1.0], [s, c, 0.0]]])
                fishes.orientation[2] = fishes.previous_orientation[2] = from_matrix(axes)[0]
                means.append([retina_brightness(renderer, world, by) for _ in range(2)])
            assert renderer.rig is rig
    for twice in means:
        assert twice[0] == twice[1]  # repeatable
        assert 0.05 < twice[0] < 0.95
    assert means[0][0] > means[1][0] + 0.05
    other.seen_light[2] = 0.125
    step(other, NEUTRAL)
    assert other.state.minds.light[2] == 0.125
    assert (other.state.minds.light[[0, 1, 3]] != 0.125).all()


@pytest.mark.nightly
def test_a_film_tells_the_light_that_its_fish_sees(tmp_path, seen):
    assert film(tmp_path / "lit", "--see-brightness") == 0
    lit = json.loads((tmp_path / "lit" / "camera.json").read_text())["frames"][-1]["fish"]["light"]
    assert lit != seen.about["frames"][-1]["fish"]["light"]
    ahead = np.mean([picture(seen, side, COUNT - 1) for side in ("left", "right")]) / 255.0
    assert lit == pytest.approx(ahead, abs=0.1)


@pytest.mark.nightly
def test_the_light_depends_on_the_dive_alone_and_not_on_how_it_is_filmed(tmp_path):
    """Levels of detail of a film with larger pictures, or another gaze, do not change it."""
    lights = []
    for k, how in enumerate((["--size", "64x64"], ["--size", "400x300", "--gaze=70,0"])):
        out = tmp_path / f"lit{k}"
        arguments = [*OPTIONS[:2], *OPTIONS[4:6], *how, "--fps", str(5 * (k + 1))]
        assert main(["film", str(out), *arguments, "--seconds", "1", "--see-brightness"]) == 0
        frames = json.loads((out / "camera.json").read_text())["frames"]
        lights.append([one["fish"]["light"] for one in frames[:: k + 1]])
    assert len(set(lights[0])) > 1
    assert lights[0] == lights[1]
