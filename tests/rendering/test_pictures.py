"""Compare drawn scenes with stored pictures."""

import numpy as np
import pytest

from subsea.view.levels import LEVELS

SIZE = (320, 180)


@pytest.mark.parametrize("level", range(len(LEVELS)))
def test_both_species_at_every_level(drawn, make_packet, fish, same_picture, level):
    fishes = [
        fish(0, (-12, 40, -193), level=level),
        fish(0, (13, 36, -193), heading=2.4, level=level),
        fish(1, (-12, 38, -207), level=level),
        fish(1, (12, 34, -206), heading=-0.6, level=level),
    ]
    same_picture(f"species-{level}", drawn(make_packet(fishes)))


def test_a_school_over_the_sand(drawn, make_packet, fish, same_picture):
    rng = np.random.default_rng(5)
    fishes = [
        fish(
            k % 2,
            tuple(np.array([0, 190, -240]) + rng.uniform(-1, 1, 3) * [110, 100, 40]),
            rng.uniform(0, 6),
            level=1 + k % 2,
            identity=rng.uniform(),
        )
        for k in range(40)
    ]
    plankton = rng.uniform((-300, 50, -260), (300, 600, -20), (200, 3)).astype(np.float32)
    packet = make_packet(fishes, pitch=-0.15, plankton=plankton)
    same_picture("school", drawn(packet))


def test_the_surface_from_below(drawn, make_packet, fish, same_picture):
    packet = make_packet([fish(0, (0, 40, -130), heading=0.3)], eye=(0, 0, -150), pitch=0.75)
    same_picture("surface", drawn(packet))


def test_two_views_beside_each_other(drawn, make_packet, fish, same_picture):
    packet = make_packet([fish(1, (0, 60, -200))], display="side-by-side")
    both = drawn(packet, SIZE)
    same_picture("side-by-side", both)
    left, right = both[:, :160], both[:, 160:]
    assert np.abs(left - right).max() > 20
