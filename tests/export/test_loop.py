"""A scene that closes: no fish jumps, slips or spins where it begins again."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.export.loop import EASE_S, GATE_S, Lead, camera_home, close, mirrored_turn
from subsea.export.recording import SceneFilmOptions, record_scene
from subsea.export.scene import Scene, SceneCamera
from subsea.export.take import Take
from subsea.frame.packet import FISH, ORIENTATION, POSITION, resting_instances
from subsea.geometry.rotation import about, matrix, multiply
from subsea.scenario.load import load_scenario
from subsea.view.rig import CameraPose
from tests.support.scenes import BARE

FPS = 15


def test_a_lead_mirrors_what_follows() -> None:
    times = np.array([0.0, 0.1, 0.2, 0.3])
    lead = Lead(np.array([2.0, 3.0, 3.5, 3.7]), times)
    assert lead.at(0.15) == pytest.approx(3.25)
    assert lead.before(0.0) == 2.0
    assert lead.before(0.1) == pytest.approx(1.0)
    assert lead.at(0.5) == pytest.approx(4.1)  # on as at the end
    early = Lead(np.array([1.0, 2.0, 3.0]), np.array([-0.2, -0.1, 0.0]))
    assert [early.before(seconds) for seconds in (0.05, 0.2, 0.3)] == pytest.approx([2.5, 1.0, 0.0])


def test_a_turn_is_mirrored() -> None:
    middle, turn = (np.array(about(0.0, 0.0, 1.0, angle)) for angle in (0.5, 0.8))
    expected = np.array(about(0.0, 0.0, 1.0, 0.2))
    np.testing.assert_allclose(mirrored_turn(middle, turn), expected, atol=1e-12)


def camera(cuts: tuple[int, ...] = ()) -> SceneCamera:
    times = np.arange(40) / FPS
    angle = 0.2 * times
    turns = np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)], axis=1)
    places = np.stack([50.0 * times, 9.0 * times**2, 0.0 * times], axis=1)
    return SceneCamera(places, turns, 1.0, 1.5, (90, 60), 1.0, 9e3, cuts)


def test_the_camera_goes_back_on_its_way() -> None:
    """No step is larger than on the way, none changes abruptly, and the last place is the first."""
    there = camera()
    back = camera_home(there, 9 * FPS, FPS)
    assert len(back.position) == 40 + 9 * FPS
    np.testing.assert_array_equal(back.position[:40], there.position)
    np.testing.assert_allclose(back.position[-1], there.position[0])
    round_trip = np.concatenate([back.position[:-1], back.position[:3]])
    speed = np.gradient(round_trip, axis=0)[1:-1] * FPS
    change = np.linalg.norm(np.diff(speed, axis=0), axis=1) * FPS
    assert np.linalg.norm(speed, axis=1).max() < 110.0
    assert change.max() < 120.0  # cm/s²: it turns round in two seconds
    dots = (back.rotation[1:] * back.rotation[:-1]).sum(axis=1)
    assert dots.min() > 0.999


def test_after_a_cut_the_camera_cuts_back_and_waits() -> None:
    back = camera_home(camera(cuts=(7,)), 20, FPS)
    assert back.cuts == (7, 40)
    assert np.ptp(back.position[40:], axis=0).max() == 0.0


def takes(places: np.ndarray, heading: np.ndarray) -> list[Take]:
    """Make takes of a fish at places (T, 3) with headings (T,)."""
    eye = CameraPose(np.zeros(3), np.eye(3)[0], np.eye(3)[2])
    rows = np.tile(resting_instances(1), (len(places), 1, 1))
    rows[:, 0, FISH], rows[:, 0, POSITION] = 0.0, places
    upright = about(1.0, 0.0, 0.0, 0.5 * np.pi)
    for row, angle in zip(rows, heading.tolist(), strict=True):
        row[0, ORIENTATION] = multiply(about(0.0, 0.0, 1.0, angle), upright)
    return [Take(row, np.zeros((0, 426, 3)), None, eye, "") for row in rows]


def eased(heading: np.ndarray, turn_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Close the film of a fish; return its places and headings on the way home.

    In its run-up it turned by 90° to the left within 0.2 s, `turn_s` before the film. On the way
    home it has the headings (T,), and swims to its first place along their mean.
    """
    speed, begin = 20.0, round(GATE_S * FPS)
    times = np.arange(-begin, 3 * FPS) / FPS
    turned = 0.5 * np.pi * np.clip((times + turn_s) / 0.2, 0.0, 1.0)
    ways = np.stack([np.cos(turned), np.sin(turned), 0.0 * turned], axis=1)
    places = np.cumsum(ways, axis=0) * speed / FPS
    places -= places[begin]
    back = np.arange(len(heading) - 1, -1, -1) / FPS
    course = [np.cos(heading.mean()), np.sin(heading.mean()), 0.0]
    home = -speed * back[:, None] * course
    known = takes(places, turned)
    joined, _ = close(known[:begin], known[begin:], takes(home, heading), FPS, 1,
                      np.zeros((1, 426, 3)))  # fmt: skip
    rows = np.array([take.rows[0] for take in joined[3 * FPS :]])
    axes = matrix(rows[:, ORIENTATION])
    np.testing.assert_allclose(axes[:, 2, 1], 1.0, atol=1e-5)  # it stays upright
    return rows[:, POSITION], np.unwrap(np.arctan2(axes[:, 1, 0], axes[:, 0, 0]))


def test_a_fish_does_not_repeat_a_sharp_turn_without_its_pose() -> None:
    """The turn of 7.9 rad/s in the run-up belongs to poses that no fish has on the way home."""
    place, heading = eased(np.zeros(10 * FPS), turn_s=2.3)
    assert np.abs(np.diff(heading)).max() * FPS < 2.5
    assert heading[0] == pytest.approx(0.0, abs=0.02) and heading[-1] == pytest.approx(np.pi / 2)
    np.testing.assert_allclose(place[-1], 0.0, atol=1e-4)


def test_a_sharp_turn_at_the_first_frame_comes_with_its_pose() -> None:
    _, heading = eased(np.zeros(10 * FPS), turn_s=0.2)
    assert np.diff(heading)[-2:].max() * FPS == pytest.approx(0.5 * np.pi / 0.2, rel=0.1)


def test_a_fish_that_comes_from_the_opposite_side_turns_round_once() -> None:
    """The shorter way between opposite headings changes; a fish that follows it spins."""
    sway = 0.3 * np.sin(np.arange(10 * FPS) / FPS * 3.0)
    _, heading = eased(sway - 0.5 * np.pi, turn_s=8.0)
    assert np.abs(np.diff(heading)).max() * FPS < 4.0
    assert np.cos(heading[-1] - 0.5 * np.pi) == pytest.approx(1.0)
    assert abs(np.ptp(heading) - np.pi) < 0.7


def test_a_beat_keeps_its_recoil() -> None:
    """A fish recoils with the beat of its own pose, also where two courses are mixed."""
    beats = 0.05 * np.sin(np.arange(10 * FPS) / FPS * 2.0 * np.pi * 2.5)
    _, heading = eased(beats, turn_s=8.0)
    _, still = eased(0.0 * beats, turn_s=8.0)
    early = slice(0, -round(0.9 * FPS))
    np.testing.assert_allclose((heading - still)[early], beats[early], atol=0.01)


@pytest.fixture(scope="module")
def closed() -> Scene:
    options = SceneFilmOptions(
        out=BARE, loaded=load_scenario(str(BARE)), fps=FPS, start=9.0, seconds=3.0, detail=3,
        groups=(), loop=True,
    )  # fmt: skip
    return record_scene(options)


def test_all_fishes_come_home(closed: Scene) -> None:
    assert closed.seamless and closed.filmed == 45 < closed.frames
    np.testing.assert_array_equal(closed.position[-1], closed.position[0])
    for fish in range(len(closed.fishes)):
        first, last = closed.points(fish, 0, 0)[0], closed.points(fish, closed.frames - 1)[0]
        np.testing.assert_array_equal(first, last)


def seconds_about_the_seam(closed: Scene, seconds: float) -> np.ndarray:
    """Frames of the last and the first seconds, in the order in which a page shows them."""
    count = round(seconds * closed.fps)
    return np.concatenate(
        [np.arange(closed.frames - 1 - count, closed.frames - 1), np.arange(count)]
    )


def test_no_fish_jumps_or_slips_at_the_seam(closed: Scene) -> None:
    """Beside the rest of the scene: speed, its change, slip across the body, and turns."""
    seam = seconds_about_the_seam(closed, EASE_S)
    rest, found = np.arange(seam[0]), {}
    for name, frames in (("rest", rest), ("seam", seam)):
        place = closed.position[frames]
        speed = np.gradient(place, axis=0) * closed.fps
        axes = matrix(closed.rotation[frames])
        slip = (speed[..., None, :] @ axes)[..., 0, 2]  # to the right of the body
        change = np.diff(speed, axis=0) * closed.fps
        turned = np.abs(axes[1:, :, :, 0] - axes[:-1, :, :, 0]).max(axis=-1) * closed.fps
        found[name] = [
            np.abs(values).max() for values in (speed[1:-1], change[1:-1], slip[1:-1], turned)
        ]
    limit = np.array([1.3, 1.3, 1.3, 1.1]) * found["rest"]
    assert (np.array(found["seam"]) < limit).all(), found


def test_tails_beat_on_through_the_seam(closed: Scene) -> None:
    """No vertex moves farther from frame to frame than elsewhere."""
    for fish in range(len(closed.fishes)):
        points = closed.points(fish)[0]
        step = np.linalg.norm(np.diff(points, axis=0), axis=2).max(axis=1)
        late = step[-round(EASE_S * closed.fps) :]
        assert late.max() < 1.5 * step[: -len(late)].max()
        assert late[-3:].max() > 0.0


def test_a_short_or_plain_scene_is_no_loop(closed: Scene) -> None:
    options = SceneFilmOptions(
        out=BARE, loaded=load_scenario(str(BARE)), fps=FPS, seconds=0.4, detail=3, groups=(),
        loop=True,
    )  # fmt: skip
    scene = record_scene(options)
    assert not scene.seamless and scene.frames == scene.filmed == 6
    assert not replace(closed, seamless=False).seamless
