"""The light of channels: gains, gammas for each colour, and masks of black."""

import numpy as np
import pytest
from PIL import Image

from subsea.base.errors import UserError
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.theatre_rig import theatre_rig

FILE = """
[[window]]
name = "left"
size = [64, 48]
[[channel]]
name = "left"
window = "left"
angles = { left_deg = -30, right_deg = 30, down_deg = -20, up_deg = 20 }
"""


@pytest.fixture
def channel(tmp_path):
    """A function that reads the channel of a file with more keys."""

    def channel(keys):
        path = tmp_path / "a.toml"
        path.write_text(FILE + keys)
        theatre, path = load_theatre(str(path))
        (found,), faults = usable_channels(theatre, path)
        assert not faults
        (patch,) = theatre_rig(theatre, [found], [0]).patches
        assert patch.gamma == found.adjustment.gamma and patch.mask is found.mask
        return found

    return channel


def test_masks_of_factors_and_of_black_come_from_pictures(channel, tmp_path):
    half = np.full((24, 32), 128, np.uint8)
    Image.fromarray(half).save(tmp_path / "half.png")
    black = np.full((12, 16), 131, np.uint16)  # 0.002 of white
    Image.fromarray(black).save(tmp_path / "black.png")
    alone = channel('black_mask = "black.png"\n').mask
    np.testing.assert_allclose(alone[3, 3], [1, 1, 1, 131 / 65535], rtol=1e-4)
    both = channel('mask = "half.png"\nblack_mask = "black.png"\n').mask
    np.testing.assert_allclose(both[3, 3], [*[128 / 255] * 3, 131 / 65535], rtol=1e-4)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("gamma = 5\n", "`gamma`: expected 0.5 to 4"),
        ("gamma = [2.2, 0.1, 2.2]\n", "`gamma`: expected 0.5 to 4"),
        ("gain = [1, 1]\n", "gain"),
        ("gain = [1, 1, 2]\n", "expected a number of at most 1"),
    ],
)
def test_other_values_are_refused_in_one_line(channel, keys, message):
    with pytest.raises(UserError) as fault:
        channel(keys)
    assert message in str(fault.value)
