"""The picture of a room shows its screens, lenses and best seat where they are."""

import numpy as np
import pytest

from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.room_picture import EYE, SIZE, room_picture
from subsea.view.test_pattern import colour_of

FILE = """
eye_cm = [{eye}, 0, 0]
scale = {scale}
window = [{{ name = "w", size = [100, 100] }}]
[[channel]]
name = "front"
window = "w"
plane = {{ lower_left = [-100, -50, 200], lower_right = [100, -50, 200], upper_left = [-100, 50, 200] }}
[room]
floor_cm = -120
projectors = {{ front = [60, 90, -150] }}
"""  # noqa: E501


def drawn(tmp_path, eye=0, scale=1.0):
    path = tmp_path / "room.toml"
    path.write_text(FILE.format(eye=eye, scale=scale))
    theatre, _ = load_theatre(str(path))
    return room_picture(theatre, usable_channels(theatre, path)[0])


def middle_of(picture, colour, part):
    """Middle (x, y) of a colour in the first, second or last third of a picture."""
    wide = SIZE[0] // 3
    own = picture[:540, part * wide : (part + 1) * wide].astype(int)
    y, x = np.nonzero(np.abs(own - np.array(colour)).max(axis=2) < 12)
    assert len(x) > 20
    return np.array([x.mean(), y.mean()])


@pytest.mark.parametrize("scale", [0.5, 1.0, 3.0])
def test_lens_screen_and_seat_lie_where_the_file_says(tmp_path, scale):
    """From above: the lens is right and behind of the seat, from the side above and behind."""
    picture = drawn(tmp_path, scale=scale)
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    screen = tuple(3 * part // 4 for part in colour_of(1))
    for part, lens_cm, screen_cm in ((0, (60, -150), (0, 200)), (1, (-150, 90), (200, 0))):
        seat = middle_of(picture, EYE, part) if part == 0 else None
        lens = middle_of(picture, colour_of(1), part)
        edge = middle_of(picture, screen, part)
        unit = np.linalg.norm(np.subtract(lens_cm, screen_cm)) / np.linalg.norm(lens - edge)
        found = (lens - edge) * unit * [1, -1]
        np.testing.assert_allclose(found, np.subtract(lens_cm, screen_cm), atol=12)
        if seat is not None:
            np.testing.assert_allclose((seat - edge) * unit * [1, -1], (0, -200), atol=12)


def test_the_seat_moves_with_the_eye(tmp_path):
    screen = tuple(3 * part // 4 for part in colour_of(1))
    for eye in (-60, 60):
        picture = drawn(tmp_path, eye)
        aside = middle_of(picture, EYE, 0) - middle_of(picture, screen, 0)
        assert np.sign(aside[0]) == np.sign(eye)
