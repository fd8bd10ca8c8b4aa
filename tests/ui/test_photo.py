"""Photo mode in a real window: a frozen sea, a free eye, a lens, captions and the gallery."""

from contextlib import closing

import numpy as np
import pytest
from PIL import Image

from subsea.dive.settings import PictureSettings, Settings
from subsea.ui import photo as photo_module
from subsea.ui.dive import Dive
from subsea.ui.photo import LensSettings
from subsea.world import snapshot
from tests.support.windows import dive_options

SIZE = (322, 240)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("photos") / "mine"


@pytest.fixture(scope="module")
def boat(display, user, quiet, folder):
    pictures = PictureSettings(folder=str(folder), logbook=False)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(photo_module, "SAMPLES", 8)
        options = dive_options(quiet, SIZE, "low", settings=Settings(pictures=pictures))
        with closing(Dive(options)) as running:
            user.glide(running, 0.3)
            yield running


@pytest.fixture
def photo(boat, user):
    user.do("key", "o")
    user.until(boat, lambda: boat.photo.open)
    yield boat.photo
    boat.photo.close()
    boat.photo.lens, boat.photo.caption = LensSettings(), ""


def taken(boat, user, folder):
    """The picture that is saved by a press of F12."""
    before = set(folder.glob("*.png"))
    user.do("key", "F12")
    user.until(boat, lambda: set(folder.glob("*.png")) - before)
    (path,) = set(folder.glob("*.png")) - before
    return np.asarray(Image.open(path)).astype(float)


def test_time_stands_still_and_goes_on(boat, photo, user):
    assert boat.timeline.paused
    before = snapshot.take(boat.world)
    user.glide(boat, 0.5)
    assert snapshot.take(boat.world) == before
    user.do("key", "Escape")
    user.until(boat, lambda: not photo.open)
    assert not boat.timeline.paused and not boat.gui.open and not boat.menu.open
    tick = boat.timeline.tick
    user.glide(boat, 0.5)
    assert boat.timeline.tick > tick


def test_paused_time_stays_paused(boat, user):
    boat.timeline.pause()
    boat.run_command("photo")
    boat.run_command("photo")
    assert boat.timeline.paused and not boat.photo.open
    boat.timeline.pause()


def test_keys_move_the_eye_and_not_the_submarine(boat, photo, user):
    user.glide(boat, 0.2)
    place, eye = boat.world.state.submarine.position.copy(), boat.picture.eye
    user.do("keydown", "w")
    user.glide(boat, 1.5)
    user.do("keyup", "w")
    moved = boat.picture.eye.eye - eye.eye
    assert moved @ eye.forward > 20.0
    assert (boat.world.state.submarine.position == place).all()


def test_a_drag_turns_the_eye(boat, photo, user):
    user.glide(boat, 0.2)
    left, top = boat.window.position
    before = boat.picture.eye.forward.copy()
    user.drag(boat, (left + 100, top + 60), (left + 180, top + 60), (left + 200, top + 80))
    turned = np.cross(before, boat.picture.eye.forward)[2]
    assert turned > 0.1  # the sea follows the pointer: the eye turns left


def test_other_commands_rest(boat, photo):
    boat.run_command("ride")
    boat.run_command("desk")
    boat.run_command("rewind")
    assert boat.picture.ride is None and photo.open and boat.timeline.paused


@pytest.mark.nightly
def test_a_lens_blurs_what_is_out_of_focus(boat, photo, user, folder):
    photo.lens = LensSettings(aperture_cm=0.0)
    sharp = taken(boat, user, folder)
    photo.lens = LensSettings(aperture_cm=6.0, focus_cm=60.0)
    blurred = taken(boat, user, folder)
    edges = [np.abs(np.diff(picture, axis=1)).mean() for picture in (sharp, blurred)]
    assert edges[1] < 0.85 * edges[0]
    assert abs(blurred.mean() - sharp.mean()) < 4.0


def test_brightness_is_that_of_the_light_before_the_tones(boat, photo, user, folder):
    photo.lens = LensSettings(aperture_cm=0.0)
    usual = taken(boat, user, folder)
    photo.lens = LensSettings(aperture_cm=0.0, brighter_ev=1.0)
    brighter = taken(boat, user, folder)
    assert brighter.mean() > 1.2 * usual.mean() and brighter.max() <= 255.0
    boat.photo.close()
    boat.frame(0.1)
    assert boat.picture.renderer._resolve.grade == boat.world.scenario.grade


def test_light_that_was_gathered_is_developed_again(boat, photo, user, folder):
    """In light a glint keeps its brightness when the lens spreads it."""
    photo.lens = LensSettings(aperture_cm=6.0, focus_cm=60.0)
    user.until(boat, lambda: boat.picture.lens and boat.picture.lens[1] == 8)
    usual = boat.window_set.picture().astype(float)
    exposures = []
    expose = boat.picture.renderer.expose
    boat.picture.renderer.expose = lambda *given, **named: exposures.append(expose(*given, **named))
    photo.lens = photo.lens._replace(brighter_ev=1.0)
    user.glide(boat, 0.3)
    del boat.picture.renderer.expose
    assert not exposures and boat.window_set.picture().mean() > 1.2 * usual.mean()


def test_a_test_pattern_in_between_begins_the_samples_again(boat, photo, user):
    photo.lens = LensSettings(aperture_cm=6.0, focus_cm=60.0)
    boat.picture.show_pattern(clear=True)
    user.glide(boat, 1.0)
    boat.picture.show_pattern(clear=True)
    boat.frame(0.1)
    assert photo._taken == 1 and not boat.picture.pattern
    user.until(boat, lambda: photo._taken == 8)
    boat.frame(0.1)
    assert boat.window_set.picture().std() > 10.0


def test_a_caption_is_on_the_saved_picture_only(boat, photo, user, folder):
    photo.lens = LensSettings(aperture_cm=0.0)
    plain = taken(boat, user, folder)
    photo.caption = "At home"
    lettered = taken(boat, user, folder)
    changed = np.abs(lettered - plain).max(axis=2) > 60.0
    assert changed[SIZE[1] // 2 :].any() and not changed[: SIZE[1] // 2].any()


def test_focus_is_what_the_pointer_clicks(boat, photo, user):
    user.glide(boat, 0.2)
    fishes = boat.world.state.fishes
    eye, way = boat.picture.front_view.ray(0.5, 0.3)
    fishes.position[0] = fishes.previous_position[0] = eye + 90.0 * way
    boat.picture.jump()
    user.glide(boat, 0.2)
    left, top = boat.window.position
    user.do("mousemove", left + SIZE[0] // 2, top + round(0.3 * SIZE[1]))
    user.glide(boat, 0.2)
    user.do("click", 1)
    user.until(boat, lambda: photo.lens.focus_cm != LensSettings().focus_cm)
    assert photo.lens.focus_cm == pytest.approx(90.0, abs=12.0)


def test_the_gallery_shows_pictures_and_leaves_out_damaged_ones(boat, photo, user, folder):
    photo.lens = LensSettings(aperture_cm=0.0)
    taken(boat, user, folder)
    (folder / "damaged.png").write_bytes(b"\x89PNG none")
    photo._open_gallery()
    user.glide(boat, 0.2)
    assert photo.in_gallery and photo._gallery[photo._leaf].name != "damaged.png"
    user.do("key", "Escape")
    user.until(boat, lambda: not photo.in_gallery)
    assert photo.open
    (folder / "damaged.png").unlink()


def test_a_full_disk_is_one_line_and_the_photo_stays(boat, photo, user, monkeypatch, tmp_path):
    blocked = tmp_path / "blocked"
    blocked.write_text("")
    monkeypatch.setattr(boat.shots, "_folder", blocked)
    photo.lens = LensSettings(aperture_cm=0.0)
    photo.caption = "Not lost"
    boat.run_command("picture")
    user.until(boat, lambda: str(blocked) in boat.overlay.note_text)
    assert photo.open and photo.caption == "Not lost"


def test_where_time_is_shared_it_says_why_not(boat, monkeypatch):
    monkeypatch.setattr(type(boat), "timeline", None)
    boat.run_command("photo")
    assert not boat.photo.open and "several computers" in boat.overlay.note_text
