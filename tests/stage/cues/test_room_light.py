"""The light on lamps: as the shaders have the water, by direction, depth and hour."""

import numpy as np
import pytest

from subsea.rendering.gl.feedback import compute_context
from subsea.rendering.gl.shaders import set_uniforms, source
from subsea.rendering.output.uniforms import light_uniforms
from subsea.scenario.schema import Water
from subsea.stage.cues.room_light import (
    SeaLight,
    dark_levels,
    filmic,
    levels_of,
    universes_of,
    water_radiance,
    ways_of,
)
from subsea.stage.theatre.theatre_file import Lamp, Lights
from subsea.view.rig import CameraPose

REEF = Water(type="II")
# The shaders' own functions, for a vertex at each direction.
PROGRAM = """
#define LINEAR 1
#define GRADED 0
#define PAGE
{optics}
{curve}
in vec3 in_way;
out vec3 out_light;
out vec3 out_shown;
void main() {{
    out_light = water_radiance(in_way);
    out_shown = curved(2.0 * out_light);
    gl_Position = vec4(0.0);
}}
"""


def at(depth, *, heading=0.0):
    ahead = np.array([np.sin(heading), np.cos(heading), 0.0])
    return CameraPose(np.array([30.0, -80.0, -depth]), ahead, np.array([0.0, 0.0, 1.0]))


def lamp(**rest):
    return Lamp(name="one", channel=1, **rest)


@pytest.mark.parametrize(("hour", "depth"), [(12.0, 300.0), (7.0, 900.0), (22.0, 300.0)])
def test_lamps_shine_what_the_shaders_draw(hour, depth):
    water = Water(type="II", hour=hour)
    rng = np.random.default_rng(4)
    ways = rng.normal(size=(200, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    uniforms = light_uniforms(water, (0.0, 0.0, -depth))
    version, _, optics = source("optics.glsl").partition("\n")
    _, _, curve = source("curve.glsl").partition("\n")
    with compute_context() as context:
        program = context.program(
            vertex_shader=f"{version}\n{PROGRAM.format(optics=optics, curve=curve)}",
            varyings=("out_light", "out_shown"),
        )
        set_uniforms(program, **uniforms)
        buffer = context.buffer(ways.astype("f4"))
        array = context.vertex_array(program, [(buffer, "3f", "in_way")])
        out = context.buffer(reserve=4 * 6 * len(ways))
        array.transform(out, context.POINTS, vertices=len(ways))
        drawn = np.frombuffer(out.read(), np.float32).reshape(-1, 6)
    mine = water_radiance(uniforms, ways)
    np.testing.assert_allclose(mine, drawn[:, :3], rtol=1e-3, atol=1e-6)
    np.testing.assert_allclose(filmic(2.0 * mine), drawn[:, 3:], rtol=2e-3, atol=1e-5)


def test_directions_are_right_up_ahead():
    ways = ways_of([lamp(), lamp(azimuth_deg=90.0), lamp(azimuth_deg=10.0, elevation_deg=90.0)])
    np.testing.assert_allclose(ways, [[0, 0, 1], [1, 0, 0], [0, 1, 0]], atol=1e-9)


def test_light_comes_from_above_and_from_the_sun():
    lamps = [lamp(elevation_deg=80.0), lamp(elevation_deg=0.0), lamp(elevation_deg=-60.0)]
    above, level, below = SeaLight(lamps).at(REEF, at(300.0), 1.0)
    assert (above > level).all() and (level > below).all()
    assert level[2] > level[1] > level[0]  # blue
    around = SeaLight([lamp(azimuth_deg=float(k), elevation_deg=50.0) for k in range(0, 360, 10)])
    turned = around.at(REEF, at(300.0, heading=np.pi / 2), 1.0)[:, 2]
    assert np.argmax(np.roll(turned, 9)) == pytest.approx(
        np.argmax(around.at(REEF, at(300.0), 1.0)[:, 2]), abs=2
    )  # a turned viewer has the sun on another side


def test_the_deep_is_bluer_and_the_night_darker():
    light = SeaLight([lamp(elevation_deg=45.0)])
    shallow, deep = light.at(REEF, at(200.0), 0.0)[0], light.at(REEF, at(2500.0), 0.0)[0]
    assert deep[0] / deep[2] < 0.5 * shallow[0] / shallow[2]
    night = light.at(Water(type="II", hour=0.0), at(200.0), 0.0)[0]
    assert night.sum() < 0.4 * shallow.sum()  # the eye opens, too


def test_a_day_that_passes_goes_through_night_and_back():
    light = SeaLight([lamp(elevation_deg=45.0)])
    water = Water(type="II", hour=12.0, day_minutes=10.0)
    noon, night, again = (light.at(water, at(3000.0), 60.0 * t)[0].sum() for t in (0.0, 5.0, 10.0))
    assert night < 0.6 * noon and abs(again - noon) < 0.1 * noon


def test_waves_focus_light_from_above_slowly_and_not_in_the_deep():
    light = SeaLight([lamp(elevation_deg=90.0), lamp(elevation_deg=-45.0)])
    times = np.arange(0.0, 60.0, 0.1)
    shown = np.array([light.at(REEF, at(300.0), t)[:, 1] for t in times])
    spread = shown.std(axis=0) / shown.mean(axis=0)
    assert 0.05 < spread[0] < 0.3 and spread[1] < 0.03
    assert np.abs(np.diff(shown[:, 0])).max() < 0.25 * shown[:, 0].mean()  # in a tenth of a second
    deep = np.array([light.at(REEF, at(3000.0), t)[0, 1] for t in times[:100]])
    assert deep.std() / deep.mean() < 0.5 * spread[0]


def test_levels_of_all_kinds_of_lamps():
    light = np.array([1.0, 0.5, 0.25])
    assert levels_of(lamp(), light) == bytes([255, 128, 64])
    assert levels_of(lamp(colours="rgbw"), light) == bytes([191, 64, 0, 64])
    assert levels_of(lamp(colours="white"), np.full(3, 0.5)) == bytes([128])
    assert levels_of(lamp(level=0.5, gamma=2.0), light)[0] == 128
    assert levels_of(lamp(gamma=2.0), light)[2] == 128
    assert levels_of(lamp(fine=True), light)[:4] == bytes([255, 255, 0x80, 0x00])


def test_universes_and_black_screens():
    lamps = [Lamp(name="a", channel=3, universe=1), Lamp(name="b", channel=1, universe=7)]
    lights = Lights(protocol="sacn", dark=0.2)
    full = universes_of(lamps, lights, np.full((2, 3), 9.0), 0.0)
    assert sorted(full) == [1, 7] and len(full[1]) == 512
    assert full[1][:6] == bytes([0, 0, 255, 255, 255, 0]) and full[7][:3] == b"\xff\xff\xff"
    black = universes_of(lamps, lights, np.full((2, 3), 9.0), 1.0)
    assert black == dark_levels(lamps, 0.2) and black[7][:3] == bytes([51, 51, 51])
