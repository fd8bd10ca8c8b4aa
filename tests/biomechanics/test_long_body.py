"""A long body: the fish's solver on more rings, its water, and its symmetries."""

import numpy as np
import pytest

from subsea.biomechanics.body import UNITS, build_body
from subsea.biomechanics.long_body import Outline, at_rest, bend, build_long_body, midline
from subsea.biomechanics.reactive_water import ALL_KEPT, section_frames
from subsea.biomechanics.simulation import NO_FORCE, STILL, copy_state, is_sound
from subsea.biomechanics.simulation import at_rest as fish_at_rest
from subsea.biomechanics.solver import STEP, Chain, advance, advance_chain

RINGS = 8
AT = np.array([0.0, *np.linspace(2.0, 38.0, RINGS), 40.0])
HEIGHT = np.array([0.0, 1.4, 2.0, 2.4, 2.4, 2.2, 1.8, 1.2, 0.8, 0.3])  # of body and fins
TICKS = 20


def body(cross_drag=1.0, skin_drag=0.01):
    outline = Outline(AT, 0.2 * HEIGHT, 0.35 * HEIGHT, HEIGHT)
    return build_long_body(outline, 400.0, 5.0, cross_drag, skin_drag)


@pytest.fixture(name="eel", scope="module")
def eel_body():
    return body()


def wave(eel, side=1.0):
    """Contractions of a beat that runs to the tail and grows in its first half."""
    at = np.arange(TICKS * 6 * eel.substeps) / (TICKS * 6 * eel.substeps)
    place = np.linspace(0.0, 1.0, eel.segments)
    beat = np.sin(2.0 * np.pi * (at[:, None] - 1.3 * place))
    return side * 0.15 * np.minimum(2.0 * at, 1.0)[:, None] * beat


def test_a_fish_is_a_chain_of_five_rings(fusilier):
    fish = build_body(fusilier.body)
    muscles = np.tile(fish.length[:12] * 0.9, (12, 1))
    one, other = fish_at_rest(fish), fish_at_rest(fish)
    advance(one.x, one.v, fish.material, muscles, STILL, NO_FORCE, STEP, one.watch)
    kept = np.array(ALL_KEPT)
    chain = Chain(fish.material, UNITS, kept)
    advance_chain(other.x, other.v, chain, muscles, STILL, NO_FORCE, STEP, other.watch)
    for name in ("x", "v", "watch"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_a_wave_of_muscles_drives_the_body_forward_and_mirrors(eel):
    left, right = at_rest(eel), at_rest(eel)
    frames = bend(eel, left, wave(eel))
    mirrored = bend(eel, right, wave(eel, -1.0))
    assert is_sound(left)
    line = midline(frames)
    np.testing.assert_allclose(line * (1, 1, -1), midline(mirrored), atol=1e-9)
    np.testing.assert_allclose(line[..., 1], 0.0, atol=1e-12)
    way = eel.body.mass @ left.x[:, 0] / eel.body.mass.sum()
    way -= eel.body.mass @ eel.body.rest[:, 0] / eel.body.mass.sum()
    assert way > 0.02 * AT[-1]


def test_body_and_water_lose_only_the_momentum_that_fins_and_tail_shed():
    eel = body(cross_drag=0.0, skin_drag=0.0)
    state = at_rest(eel)
    bend(eel, state, wave(eel))
    step, sections = STEP / eel.substeps, eel.body.sections

    def frames(x):
        tangent, normal = np.empty((2, RINGS + 1, 3))
        section_frames(x, tangent, normal)
        return tangent, normal

    def momentum(x, v):
        before = frames(x - step * v)[1]
        along = np.einsum("ki,ki->k", midline(v)[1:], before)
        return eel.body.mass @ v + (sections.added * along) @ before

    (tangent, normal), speed = frames(state.x), midline(state.v)[1:]
    u, w = (np.einsum("ki,ki->k", speed, axis)[:, None] for axis in (tangent, normal))
    carried = u * w * normal - 0.5 * w * w * tangent
    between = np.append(0.5 * (carried[:-1] + carried[1:]), carried[-1:], axis=0)
    shed = (sections.flux * (1.0 - eel.chain.kept)) @ between
    lost = momentum(state.x, state.v)
    after = copy_state(state)
    muscles = np.tile(eel.body.length[: 4 * eel.segments], (1, 1))
    force = np.zeros(after.x.shape)
    advance_chain(after.x, after.v, eel.chain, muscles, STILL, force, step, after.watch)
    lost = (lost - momentum(after.x, after.v)) / step
    np.testing.assert_allclose(lost[[0, 2]], shed[[0, 2]], rtol=1e-6, atol=1e-8)
    # Most of it leaves along the fins, in front of the tail's edge.
    assert 0.0 < abs(sections.flux[-1] * between[-1, 0]) < 0.5 * abs(shed[0])
