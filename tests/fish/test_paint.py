"""The painted skins."""

from functools import partial

import numpy as np
import pytest
from msgspec import structs

from subsea.fish.paint import paint
from subsea.fish.sheet_layout import (
    BODY,
    DORSAL,
    PECTORAL,
    PELVIC,
    VENTRAL,
    borders,
    eye_height,
    half_height,
)
from subsea.fish.species import FinSkin, SkinPatch, Stripes, load_species, species_names

SIZE = (256, 160)


def crop(picture, frame):
    """The part of a skin in one of its frames."""
    height, width = picture.shape[:2]
    rows = slice(round(frame.bottom * height), round(frame.top * height))
    return picture[rows, round(frame.left * width) : round(frame.right * width)]


def texel(species, picture, s, y):
    body = crop(picture, BODY)
    top = half_height(species.surface)
    front, rear = borders(species.surface)
    column = int((s - front) / (rear - front) * body.shape[1])
    row = int((y + top) / (2 * top) * body.shape[0])
    return body[row, column].astype(int)


@pytest.mark.parametrize("name", species_names())
def test_a_skin_is_repeatable_with_opaque_body_own_fins_and_the_eye_in_place(name):
    species = load_species(name)
    surface, eye = species.surface, species.surface.eye
    picture = paint(species, SIZE)
    assert picture.shape == (160, 256, 4)
    assert picture.dtype == np.uint8
    np.testing.assert_array_equal(picture, paint(species, SIZE))
    assert texel(species, picture, 0.3, 0.0)[3] == 255
    for frame, fin in (
        (DORSAL, surface.dorsal),
        (VENTRAL, surface.ventral),
        (PECTORAL, surface.pectoral),
        (PELVIC, surface.pelvic),
    ):
        assert (crop(picture, frame)[..., 3] > 0).any() == (fin is not None)
    picture, height = paint(species), eye_height(surface)
    pupil = texel(species, picture, eye.at, height)
    iris = texel(species, picture, eye.at + 0.77 * eye.radius, height)
    assert pupil[:3].max() < 60
    assert iris[:3].max() > pupil[:3].max() + 60


def test_the_frames_share_the_sheet_without_overlap():
    sheet = np.zeros((160, 256), int)
    for frame in (BODY, DORSAL, VENTRAL, PECTORAL, PELVIC):
        crop(sheet, frame)[:] += 1
    assert (sheet == 1).all()


def test_a_membrane_is_clear_between_rays_and_frays_at_its_edge(painted_sheet):
    dorsal = crop(
        painted_sheet(dorsal=FinSkin(colour=RED, opacity=0.3, spines=0, soft_rays=12)), DORSAL
    ).astype(int)
    opacity = dorsal[int(0.8 * len(dorsal)), 100:-100, 3]
    rise = opacity > (opacity.min() + opacity.max()) / 2
    # Half out each ray has parted: two to each.
    assert np.abs(np.diff(rise.astype(int))).sum() / 2 == pytest.approx(
        2 * 12 * len(opacity) / dorsal.shape[1], abs=2
    )
    assert opacity.max() > opacity.min() + 30
    assert (dorsal[0, 100:-100, 3] == 255).all()  # the root in the body
    assert (dorsal[-1, 100:-100, 3] < 60).all()
    solid = crop(painted_sheet(dorsal=FinSkin(colour=RED, opacity=1.0, soft_rays=0)), DORSAL)
    assert (solid[:-4, 100:-100, 3] == 255).all()


def test_spines_stand_out_of_the_membrane(painted_sheet):
    def tips(**rays):
        dorsal = crop(painted_sheet(dorsal=FinSkin(colour=RED, opacity=1.0, **rays)), DORSAL)
        return (dorsal[-6, 100:-100, 3] > 127).mean()

    assert tips(spines=10, soft_rays=0) < tips(spines=0, soft_rays=10)


def test_a_paired_fin_grows_out_of_the_flank(painted_sheet):
    picture = painted_sheet(flank=BLUE, belly=BLUE, paddles=FinSkin(colour=RED))
    pectoral = crop(picture, PECTORAL).astype(int)
    middle = len(pectoral) // 2
    root, end = pectoral[middle, 4], pectoral[middle, 180]
    assert root[2] > 1.5 * max(root[:2])
    assert reddest(end)


RED, GREEN, BLUE = (0.8, 0.0, 0.0), (0.0, 0.8, 0.0), (0.0, 0.0, 0.8)


@pytest.fixture
def painted_sheet():
    """The fusilier with parts of its skin replaced -> the whole sheet."""
    fusilier = load_species("fusilier")
    return lambda **parts: paint(
        structs.replace(fusilier, skin=structs.replace(fusilier.skin, **parts))
    )


@pytest.fixture
def painted(painted_sheet):
    """The same -> a function that returns the texel at (distance, height)."""
    fusilier = load_species("fusilier")
    return lambda **parts: partial(texel, fusilier, painted_sheet(**parts))


def reddest(rgba):
    return rgba[0] > 1.5 * max(rgba[1:3])


def test_the_tail_has_its_colour_and_all_its_edges_the_rim(painted):
    at = painted(tail=FinSkin(colour=GREEN, rim=RED, rim_width=0.02))
    assert at(0.865, 0.0)[1] > 1.5 * max(at(0.865, 0.0)[[0, 2]])
    for place in [(0.955, 0.07), (0.955, -0.07), (0.95, 0.095), (0.95, -0.095)]:
        assert reddest(at(*place))


def test_stripes_run_along_or_upright(painted):
    along_body, upright = (
        painted(
            cape=None,
            flank=BLUE,
            stripes=Stripes(
                colour=RED, spacing=0.06, share=0.5, begin=0.35, end=0.6, upright=upright
            ),
        )
        for upright in (False, True)
    )
    level = np.array([reddest(upright(s, 0.0)) for s in np.linspace(0.39, 0.55, 60)])
    across = np.array([reddest(upright(0.45, y)) for y in np.linspace(-0.06, 0.06, 60)])
    assert 0.3 < level.mean() < 0.7
    assert across.mean() in (0.0, 1.0) or np.abs(np.diff(across)).sum() <= 1
    across = np.array([reddest(along_body(0.45, y)) for y in np.linspace(-0.06, 0.06, 60)])
    assert 0.3 < across.mean() < 0.7
    for at in (along_body, upright):
        beside = [reddest(at(s, y)) for s in (0.3, 0.63) for y in np.linspace(-0.06, 0.06, 20)]
        assert not any(beside)


@pytest.mark.parametrize("over_fins", [False, True])
def test_a_patch_lies_under_the_fins_or_over_them(painted_sheet, over_fins):
    outline = [(0.36, -0.1), (0.36, 0.2), (0.5, 0.2), (0.5, -0.1)]
    picture = painted_sheet(patches=[SkinPatch(outline=outline, colour=RED, over_fins=over_fins)])
    assert reddest(texel(load_species("fusilier"), picture, 0.43, 0.05))
    dorsal = crop(picture, DORSAL).astype(int)
    begin, end = load_species("fusilier").surface.dorsal.base
    above = dorsal[int(0.8 * len(dorsal)), int((0.43 - begin) / (end - begin) * dorsal.shape[1])]
    assert reddest(above) == over_fins
    assert above[3] < 255


def test_a_clear_back_lets_light_through(painted):
    at = painted(clear_back=0.4)
    assert at(0.45, 0.09)[3] == pytest.approx(0.6 * 255, abs=2)
    assert at(0.45, -0.05)[3] == 255
    assert at(0.06, 0.02)[3] == 255  # the head stays opaque


def test_gill_slits_are_counted(painted):
    def slits(gills):
        at = painted(gills=gills, cape=None, blotches=0.0, patches=[])
        row = np.array([at(s, 0.0)[:3].sum() for s in np.linspace(0.14, 0.30, 320)])
        dark = row < 0.9 * np.median(row)
        return int((dark[1:] & ~dark[:-1]).sum())

    assert (slits(1), slits(5)) == (1, 5)


def test_a_patch_beyond_the_skin_changes_nothing(painted):
    outside = SkinPatch(outline=[(0.2, 3.0), (0.3, 3.2), (0.4, 3.0)], colour=RED)
    with_it, without = painted(patches=[outside]), painted(patches=[])
    np.testing.assert_array_equal(with_it(0.3, 0.0), without(0.3, 0.0))


def test_the_outline_of_a_patch_is_where_it_was_drawn(painted):
    """A large disc of red: its area, within the blur of its border."""
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    outline = [(0.45 + 0.07 * np.cos(a), 0.07 * np.sin(a)) for a in angle]
    at = painted(cape=None, flank=BLUE, patches=[SkinPatch(outline=outline, colour=RED)])
    axis = np.linspace(-0.1, 0.1, 101)
    share = np.mean([reddest(at(0.45 + x, y)) for x in axis for y in axis])
    assert share == pytest.approx(np.pi * 0.07**2 / 0.2**2, rel=0.06)


def test_wings_are_painted_on_both_sides():
    ray = load_species("spotted_eagle_ray")
    skin = ray.skin
    disc = structs.replace(skin.spots, colour=RED, radius=(0.006, 0.006), spacing=0.02, rings=0.0)
    patch = SkinPatch(outline=[(0.14, 0.08), (0.2, 0.08), (0.2, 0.14), (0.14, 0.14)], colour=GREEN)
    changed = structs.replace(
        skin, back=BLUE, flank=BLUE, belly=(0.8, 0.8, 0.8), spots=disc, patches=[patch]
    )
    picture = crop(paint(structs.replace(ray, skin=changed)), BODY).astype(int)
    above, below = picture[256:][::-1], picture[:256]  # from the spine outward
    top = half_height(ray.surface)
    front, rear = borders(ray.surface)

    def at(side, s, right):
        return side[int(256 * right / top), int((s - front) / (rear - front) * 1024)]

    assert at(above, 0.17, 0.11)[1] > at(above, 0.17, 0.11)[[0, 2]].max() + 60
    np.testing.assert_allclose(at(below, 0.17, 0.11), at(below, 0.2, 0.02), atol=40)
    disc_texels = above[:80, 200:700]
    red = disc_texels[..., 0] > disc_texels[..., 2]
    cover = np.pi * 0.006**2 / (0.02**2 * np.sqrt(0.75))
    assert red.mean() == pytest.approx(cover, rel=0.35)
    assert (below[..., 0] - below[..., 2]).max() < 40  # no spot below
    edge = (
        at(above, 0.2, ray.surface.wing.span + 0.01),
        at(below, 0.2, ray.surface.wing.span + 0.01),
    )
    np.testing.assert_allclose(*edge, atol=25)  # both sides are one colour at the edge
