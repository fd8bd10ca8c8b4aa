"""The open water, its surface and the shafts of light."""

from dataclasses import replace

import numpy as np
import pytest
from msgspec import structs

from subsea.habitat.stone import SUN, sun_at
from subsea.rendering.gl.shaders import set_uniforms, source
from subsea.rendering.gl.textures import near_and_far, repeating, ripples
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.output.uniforms import WIDE, daylight, light_uniforms, uniforms_of
from subsea.rendering.sea.water import MOST_SLOPE, disc, grid, wave_levels
from subsea.scenario.schema import JERLOV, LUMINANCE, Water, attenuation

PLAIN_WATER = Water(fog=(0.01, 0.1, 0.2), visibility_cm=1500.0)
PLAIN = replace(PRESETS["medium"], smooth=False, snow=0)


@pytest.fixture(scope="module")
def look(drawn, scene, make_packet):
    """Quality, eye and options of `make_packet` -> the picture of an empty sea, in grey levels."""
    bottomless = replace(scene, terrain=scene.terrain - np.float32(5000.0))
    return lambda quality=PLAIN, **options: drawn(
        make_packet([], size=(160, 90), **options), scene=bottomless, quality=quality
    )


def test_a_grid_covers_its_rectangle_once():
    triangles = grid(5, 3)
    corners = np.stack([triangles % 6, triangles // 6], axis=2)
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    (u, v), (s, t) = (b - a).T, (c - a).T
    areas = (u * t - v * s) / 2
    np.testing.assert_array_equal(areas, 0.5)
    assert len(np.unique(corners.mean(axis=1).round(6), axis=0)) == 2 * 5 * 3


def test_the_rings_of_the_disc_reach_its_edge():
    places, triangles = disc(7, 24)
    assert np.linalg.norm(places[triangles], axis=2).max() == pytest.approx(1.0)
    assert np.linalg.norm(places, axis=1).min() == 0.0


def test_each_mipmap_of_the_waves_keeps_their_mean_square_slope():
    """The variance of a level holds the slopes that it averages out."""
    square = sum((slope**2).mean() for slope in ripples(5))
    levels = wave_levels(5)
    assert [len(level) for level in levels] == [256 >> k for k in range(9)]
    for level in levels:
        x, y = np.moveaxis(MOST_SLOPE * (2.0 * level[..., :2] / 255.0 - 1.0), 2, 0)
        lost = MOST_SLOPE * level[..., 2] / 255.0
        assert (x**2 + y**2 + lost).mean() == pytest.approx(square, rel=0.02)
    assert not levels[0][..., 2].any()


def test_light_comes_from_above_and_the_deep_is_blue(look):
    up, level, down = (
        look(eye=(0, 0, -120), pitch=pitch).mean(axis=(0, 1)) for pitch in (1.2, 0.0, -0.6)
    )
    assert up.sum() > 1.5 * level.sum()
    assert level[2] > level[1] > level[0]
    assert level.sum() > down.sum()


def test_it_gets_darker_and_bluer_with_depth(look):
    shallow, deep = (look(eye=(0, 0, z)).mean(axis=(0, 1)) for z in (-500, -2500))
    assert deep.sum() < 0.85 * shallow.sum()
    assert deep[2] / deep[1] > shallow[2] / shallow[1]


@pytest.mark.parametrize("depth", [30.0, 150.0])
def test_snells_window_has_the_size_that_refraction_gives_it(look, depth):
    """The bright edge lies 48.6° from the vertical, whatever the depth.

    Measured where the light has fallen halfway from the sky to the mirrored part; waves of many
    places and moments are averaged, at three headings off the sun.
    """
    pitch, away = np.radians(48.0), np.arctan2(SUN[1], SUN[0]) + np.pi
    rows = [
        look(
            eye=(x, 0, -depth), pitch=pitch, heading=away + turn, time_s=2.0 + 0.05 * x
        )[:, 70:90].mean(axis=1)
        for turn in (-np.pi / 2, 0.0, np.pi / 2)
        for x in range(0, 1200, 100)
    ]  # fmt: skip
    light = ((np.mean(rows, axis=0) / 255.0) ** 2.2).sum(axis=1)
    slope = (44.5 - np.arange(90)) / 45.0 * np.tan(np.radians(27.5))
    zenith = 90.0 - np.degrees(pitch + np.arctan(slope))
    bright, dark = light[zenith < 38.0].mean(), light[zenith > 64.0].mean()
    assert bright > 2.0 * dark
    edge = np.interp(-0.5 * (bright + dark), -light[zenith > 38.0], zenith[zenith > 38.0])
    assert edge == pytest.approx(np.degrees(np.arcsin(1.0 / 1.33)), abs=3.0)


def test_shafts_move_in_the_light_and_are_gone_where_none_are_asked_for(look):
    none = replace(PLAIN, shafts=0)
    options = {"eye": (0, 0, -150), "pitch": 0.1, "heading": 0.55}
    with_shafts, without = look(PLAIN, **options), look(none, **options)
    assert np.abs(with_shafts - without).mean() > 0.5
    assert np.abs(with_shafts.mean() - without.mean()) < 3.0  # they add no light
    later = look(PLAIN, time_s=12.0, **options)
    assert np.abs(later - with_shafts)[:45].mean() > 0.5
    np.testing.assert_array_equal(look(none, **options), without)


def test_after_a_month_the_water_moves_as_evenly_as_at_first(look):
    options = {"eye": (0, 0, -120), "pitch": 1.2}

    def steps(begin):
        shown = [look(PLAIN, time_s=begin + k / 60, **options) for k in range(4)]
        return np.abs(np.diff(shown, axis=0)).mean(axis=(1, 2, 3))

    at_first, later = steps(10.0), steps(30 * 86400.0 + 10.0)
    assert later.min() > 0.5 * at_first.min() > 0.0


def test_no_edge_of_the_surface_is_seen(look):
    """From the horizon up to 15° beyond it rows brighten little by little."""
    for z in (-300.0, -2000.0):
        rows = look(replace(PLAIN, shafts=0), eye=(0, 0, z), pitch=0.15)[:, 60:100].mean(axis=1)
        assert np.abs(np.diff(rows[30:65], axis=0)).max() < 6.0


@pytest.fixture(scope="module")
def optics(context):
    """A GLSL expression of `vec3 p`, and places (n, 3) -> its values (n, 3), by `optics.glsl`."""
    light = repeating(context, near_and_far, 1)
    target = context.simple_framebuffer((4, 4))

    def optics(expression, places, water=PLAIN_WATER, **uniforms):
        main = f"in vec3 p; out vec3 v; void main() {{ v = vec3({expression}); }}\n"
        compiled = context.program(vertex_shader=source("optics.glsl") + main, varyings=["v"])
        given = context.buffer(np.asarray(places, "f4").tobytes())
        out = context.buffer(reserve=12 * len(places))
        array = context.vertex_array(compiled, [(given, "3f4", "p")])
        target.use()
        light.use(1)
        eye = uniforms.get("u_eye", (0.0, 0.0, -300.0))
        sea = {"u_eye": eye, "u_caustics": 1, "u_time": 3.0} | light_uniforms(water, eye)
        set_uniforms(compiled, **(sea | uniforms))
        array.transform(out, vertices=len(places))
        values = np.frombuffer(out.read(), np.float32).reshape(-1, 3).astype(float)
        for held in (array, out, given, compiled):
            held.release()
        return values

    yield optics
    light.release()
    target.release()


def bottom(z, number=20_000, seed=1):
    """Places (n, 3) all over a bay at a depth."""
    across = np.random.default_rng(seed).uniform(-1500.0, 1500.0, (number, 2))
    return np.column_stack([across, np.full(number, z)])


def test_caustics_spread_the_light_but_add_none_and_are_softer_with_depth(optics):
    light = {z: optics("caustics_at(p)", bottom(z))[:, 0] for z in (-150.0, -600.0, -2000.0)}
    for values in light.values():
        assert values.mean() == pytest.approx(1.0, abs=0.1)
        assert values.min() > 0.0
    spread = [values.std() for values in light.values()]
    assert spread[0] > 1.2 * spread[1] > 1.2 * 1.2 * spread[2] > 0.1
    # At the surface itself no light is focused yet.
    np.testing.assert_allclose(optics("caustics_at(p)", bottom(0.0)), 1.0, atol=1e-6)


def test_no_tile_of_caustics_repeats(optics):
    """The pattern never repeats along either texture's axes."""
    places = bottom(-400.0)
    light = optics("caustics_at(p)", places)[:, 0]
    for turn in ([[0.0029, -0.0009], [0.0009, 0.0029]], [[-0.0010, -0.0035], [0.0035, -0.0010]]):
        for step in ([1, 0], [0, 1], [2, 1]):
            along = np.linalg.solve(turn, step)
            there = optics("caustics_at(p)", places + [*along, 0.0])[:, 0]
            assert np.corrcoef(light, there)[0, 1] < 0.7


def test_caustics_move(optics):
    places = bottom(-400.0)
    now, soon, later = (optics("caustics_at(p)", places, u_time=t)[:, 0] for t in (3.0, 3.03, 5.0))
    assert np.corrcoef(now, soon)[0, 1] > 0.9
    assert np.corrcoef(now, later)[0, 1] < 0.5


def test_colours_near_the_eye_are_true_on_a_reef_and_blue_in_the_deep(optics):
    """Remaining share of white light, after the eye's adaptation."""
    for depth, most in ((100.0, 0.12), (350.0, 0.25)):
        eye = (0.0, 0.0, -depth)
        red, _, blue = optics("daylight(p.z)", [eye], u_eye=eye)[0]
        assert abs(red - blue) < most
    deep = (0.0, 0.0, -2500.0)
    red, green, blue = optics("daylight(p.z)", [deep], u_eye=deep)[0]
    assert red < 0.3 * green < 0.3 * blue
    # From anywhere, deeper places are darker, most of all in red.
    shares = optics("daylight(p.z - 300.0) / daylight(p.z)", [deep], u_eye=deep)[0]
    np.testing.assert_allclose(shares, np.exp([-0.6, -0.24, -0.126]), rtol=1e-5)


def test_reds_are_kept_near_and_the_visibility_is_where_two_percent_of_contrast_is_left(optics):
    near, far = optics("clearness(p.x)", [(250.0, 0, 0), (1500.0, 0, 0)])
    assert near[0] > 0.4
    assert near[0] / near[2] > 0.7
    assert far[1] == pytest.approx(0.02, abs=0.001)
    assert far[0] < 0.5 * far[2]


def test_the_water_is_brightest_about_the_sun_and_darkest_below(optics):
    sun = np.array(SUN)
    toward, level, away, down = optics(
        "water_radiance(normalize(p))", [sun, (0.8, 0.5, 0.0), (-0.8, -0.5, 0.0), (0.0, 0.0, -1.0)]
    ).sum(axis=1)
    assert toward > 2.0 * level
    assert level > 1.3 * away
    assert away > 1.5 * down


@pytest.mark.parametrize("name", JERLOV)
def test_daylight_falls_with_depth_as_jerlov_measured_it(optics, name):
    """Green and blue as in the table, red between those of 550 and 650 nm."""
    water, places = Water(type=name), [(0.0, 0.0, -500.0), (0.0, 0.0, -600.0)]
    high, low = optics("daylight(p.z)", places, water=water)
    red, green, blue = -np.log(low / high)  # over a metre
    kd = JERLOV[name].kd
    np.testing.assert_allclose((green, blue), kd[1:], rtol=1e-4)
    assert kd[1] < red < kd[0]
    np.testing.assert_allclose((red, green, blue), 100.0 * np.array(attenuation(name)), rtol=1e-4)


def test_near_things_are_warm_and_far_ones_have_the_colour_of_their_water(optics):
    for name, clearest in (("I", 2), ("II", 2), ("5C", 1), ("9C", 1)):
        water = Water(type=name)
        far = optics("clearness(p.x)", [(water.visibility_cm, 0, 0)], water=water)[0]
        assert far[1] == pytest.approx(0.02, abs=0.001)
        assert far.argmax() == clearest
        assert np.argmax(water.far) == clearest
        near = optics("clearness(p.x)", [(0.1 * water.visibility_cm, 0, 0)], water=water)[0]
        assert near.min() > 3.0 * far.max()


def test_pictures_of_one_eye_have_one_exposure(make_packet, scene):
    """Whatever the screen, its direction and its size."""
    size, eye = (320, 180), (30.0, -40.0, -420.0)
    found = []
    for heading, pitch in ((0.0, 0.0), (2.0, 0.7), (4.0, -0.9)):
        packet = make_packet([], eye=eye, heading=heading, pitch=pitch, size=size)
        found.append(uniforms_of(packet, packet.views[0], scene.water))
    for name in light_uniforms(scene.water, eye):
        assert found[0][name] == found[1][name] == found[2][name], name


def test_the_pupil_opens_in_the_dark_a_little():
    for dim in (Water(type="II", hour=17.0), Water(type="5C")):
        assert 1.2 < daylight(dim).pupil(350.0) <= WIDE
    clear = daylight(PLAIN_WATER)
    assert clear.pupil(350.0) == pytest.approx(1.0)
    # Deep places stay darker all the same.
    light = [clear.at(depth)[1] * clear.pupil(depth) for depth in (100.0, 350.0, 1000.0, 2500.0)]
    assert (np.diff(light) < 0.0).all()


def test_light_is_dimmer_and_redder_in_the_evening():
    noon, late = (daylight(Water(type="II", hour=hour)) for hour in (12.0, 17.0))
    assert (late.sunlight < 0.6 * noon.sunlight).all()
    assert late.sunlight[0] / late.sunlight[2] > 1.3 * noon.sunlight[0] / noon.sunlight[2]
    assert (late.far < 0.6 * noon.far).all()


MOVING = Water(type="II", day_minutes=12.0)


def brightness(hour):
    """Luminance of level light about an eye at 3 m at an hour, with its pupil."""
    light = daylight(structs.replace(MOVING, hour=hour))
    level = light.sun[2] * light.sunlight + light.skylight
    return float(LUMINANCE @ (level * light.at(300.0))) * light.pupil(300.0)


def test_the_light_of_a_day_changes_smoothly_and_is_never_black():
    seen = [brightness(hour) for hour in np.arange(0.0, 24.0, 0.05)]
    assert min(seen) > 0.12 * max(seen)
    assert np.argmax(seen) == pytest.approx(240, abs=1)
    change = np.abs(np.diff(np.log(seen)))
    assert change.max() < 0.12  # in three minutes of the day
    ways = np.array([sun_at(hour)[0] for hour in np.arange(0.0, 24.0, 0.05)])
    assert (ways[:, 2] > 0.6).all()
    assert np.linalg.norm(np.diff(ways, axis=0), axis=1).max() < 0.08


def test_night_is_blue_and_its_shafts_are_faint():
    noon, night = daylight(MOVING), daylight(structs.replace(MOVING, hour=0.0))
    assert night.skylight[2] / night.skylight[0] > 1.2 * noon.skylight[2] / noon.skylight[0]
    assert night.sunlight.max() < 0.05 * noon.sunlight.max()
    assert night.shafts < 0.5 < noon.shafts == 1.0


def test_a_packet_gives_the_hour_to_a_moving_clock(make_packet, scene):
    packet = make_packet([], eye=(0.0, 0.0, -300.0), heading=0.0, pitch=0.0, size=(320, 180))
    (view,) = packet.views
    late = uniforms_of(replace(packet, hour=15.0), view, MOVING)
    assert late["u_sun"] == uniforms_of(packet, view, structs.replace(MOVING, hour=15.0))["u_sun"]
    assert late["u_sun"] != uniforms_of(packet, view, MOVING)["u_sun"]
