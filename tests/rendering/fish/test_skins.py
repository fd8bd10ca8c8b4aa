"""Skins in the light: individual variation, mating colours of males, mirroring silver."""

from dataclasses import replace

import numpy as np
import pytest
from msgspec import structs

from subsea.fish.species import CourtshipColours, Variation

SIZE = (320, 200)
ALIKE = Variation(hue=0.0, saturation=0.0, brightness=0.0, pattern=0.0, torn=0.0, scarred=0.0)


@pytest.fixture(scope="module")
def dressed(drawn, scene, make_packet, fish):
    """Keys of the angelfish's skin -> its records -> pictures (h, w, 3) of its flank."""

    def dressed(**skin):
        angelfish = scene.species[1]
        changed = structs.replace(angelfish, skin=structs.replace(angelfish.skin, **skin))
        theirs = replace(scene, species=(scene.species[0], changed))
        return lambda **record: drawn(
            make_packet([fish(1, (0.0, 17.0, -200.0), **record)], size=SIZE), scene=theirs
        )

    return dressed


def changed(a, b):
    """The share of pixels that differ clearly."""
    return (np.abs(a - b).max(axis=2) > 12).mean()


def test_without_variation_all_are_alike(dressed):
    draw = dressed(variation=ALIKE, scales=0.0)
    # But for the way they look.
    assert changed(draw(identity=0.1), draw(identity=0.55)) < 0.001


@pytest.mark.parametrize(
    "key", [{"hue": 0.3}, {"saturation": 0.5}, {"brightness": 0.4}, {"pattern": 0.02}]
)
def test_each_kind_of_variation_shows_and_is_the_same_each_time(dressed, key):
    draw = dressed(variation=structs.replace(ALIKE, **key), scales=0.0)
    first = draw(identity=0.1)
    assert changed(first, draw(identity=0.55)) > 0.02
    np.testing.assert_array_equal(first, draw(identity=0.1))


def test_a_displaced_pattern_leaves_the_outline_as_it_is(dressed):
    draw = dressed(variation=structs.replace(ALIKE, pattern=0.03), scales=0.0)
    a, b = draw(identity=0.1), draw(identity=0.55)
    rows, columns = np.nonzero(np.abs(a - b).max(axis=2) > 12)
    fish_rows = np.nonzero((np.abs(a - a[:, :1]).max(axis=2) > 40).any(axis=1))[0]
    # Inside the body: neither at the ridges nor where the head and the tail fin are.
    assert rows.min() > fish_rows.min() + 5
    assert rows.max() < fish_rows.max() - 5
    assert np.ptp(columns) < 0.75 * SIZE[0]


def test_a_torn_fin_lets_the_water_show(dressed):
    whole, torn = dressed(variation=ALIKE), dressed(variation=structs.replace(ALIKE, torn=1.0))
    one = whole(identity=0.3)
    nick = changed(one, torn(identity=0.3))
    assert 0.0005 < nick < 0.02
    assert changed(one, whole(identity=0.3)) == 0.0


def test_a_scar_is_a_small_part_of_one_flank_and_always_in_the_same_place(dressed):
    plain, scarred = (
        dressed(variation=structs.replace(ALIKE, scarred=share)) for share in (0.0, 1.0)
    )
    identities = (0.1, 0.3, 0.55, 0.7, 0.85)
    shares = [changed(plain(identity=own), scarred(identity=own)) for own in identities]
    assert 0.0 < max(shares) < 0.05
    assert min(shares) == 0.0  # on the side that is not seen
    own = identities[int(np.argmax(shares))]
    np.testing.assert_array_equal(scarred(identity=own), scarred(identity=own))


def test_eyes_look_about_and_nothing_else_moves(drawn, scene, make_packet, fish):
    """In a still pose only pixels of the eye change with the time of the water."""
    one = fish(1, (0.0, 17.0, -200.0))
    still = replace(scene, species=(scene.species[0], scene.species[1]))
    pictures = [
        drawn(make_packet([one], size=SIZE, time_s=2.0 + 0.001 * k), scene=still)
        for k in (0, 1, 1500, 3000, 4500)
    ]
    quick = changed(pictures[0], pictures[1])
    moved = [(np.abs(picture - pictures[0]).max(axis=2) > 40) for picture in pictures[2:]]
    assert quick < 0.001
    assert max(mask.sum() for mask in moved) > 5


def test_mating_colours_replace_what_is_near_one_colour(dressed):
    yellow, red = (0.98, 0.60, 0.02), (0.9, 0.02, 0.02)
    draw = dressed(variation=ALIKE, display=CourtshipColours(of=yellow, to=red, reach=0.5))
    plain, courting = draw(), draw(display=1.0)
    gold = (plain[..., 1] > 1.6 * plain[..., 2]) & (plain[..., 0] > 100)
    assert gold.mean() > 0.05
    turned = courting[gold]
    assert np.mean(turned[:, 0] > 1.6 * turned[:, 1]) > 0.8
    blue = plain[..., 2] > 1.5 * plain[..., 0]
    assert np.abs(plain - courting).max(axis=2)[blue].mean() < 6
    halfway = draw(display=0.5)[gold]
    assert plain[gold][:, 1].mean() > halfway[:, 1].mean() > turned[:, 1].mean()


def test_a_species_without_mating_colours_keeps_its_own(dressed):
    draw = dressed(display=None)
    assert changed(draw(), draw(display=1.0)) == 0.0


def test_a_clear_fin_lets_more_of_the_water_show_than_a_dense_one(dressed, scene):
    fin = scene.species[1].skin.dorsal
    pictures = [
        dressed(variation=ALIKE, dorsal=structs.replace(fin, opacity=opacity, rim=None))()
        for opacity in (1.0, 0.2)
    ]
    water = pictures[0][:, :1]
    fins = np.abs(pictures[0] - pictures[1]).max(axis=2) > 12
    assert fins.mean() > 0.01
    dense, clear = (np.abs(p - water).max(axis=2)[fins].mean() for p in pictures)
    assert clear < 0.9 * dense


def test_silver_mirrors_the_water_and_only_what_is_pale(dressed):
    dull, silvery = (dressed(variation=ALIKE, silver=silver)() for silver in (0.0, 1.0))
    pale = (dull.min(axis=2) > 110) & (np.ptp(dull, axis=2) < 70)
    pale &= np.abs(silvery - dull).max(axis=2) > 0  # not the sand
    assert pale.mean() > 0.01
    bluer = (silvery[..., 2] - silvery[..., 0]) - (dull[..., 2] - dull[..., 0])
    assert bluer[pale].mean() > 8
    golden = (dull[..., 0] > 1.8 * dull[..., 2]) & (dull[..., 0] > 120)
    assert np.abs(silvery - dull).max(axis=2)[golden].mean() < 4


def test_scales_differ_from_place_to_place_and_fish_to_fish(dressed):
    smooth = dressed(variation=ALIKE, scales=0.0)
    scaly = dressed(variation=ALIKE, scales=1.0)
    relief = [np.abs(scaly(identity=i) - smooth(identity=i)).max(axis=2) for i in (0.1, 0.55)]
    assert relief[0].max() > 8
    assert (relief[0] != relief[1]).mean() > 0.005
