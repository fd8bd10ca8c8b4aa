"""The slender body's water against closed forms, its symmetries and its balance of momentum."""

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from subsea.biomechanics.body import NODES, Floats, build_body
from subsea.biomechanics.body_plan import BodyPlan
from subsea.biomechanics.reactive_water import (
    ALL_KEPT,
    SECTIONS,
    add_section_forces,
    make_sections,
    section_frames,
)
from subsea.biomechanics.simulation import at_rest, simulate
from subsea.biomechanics.solver import STEP, advance

STILL = np.zeros(3)


@pytest.fixture(name="slender")
def slender_plan(fusilier):
    return msgspec.structs.replace(fusilier.body, water="elongated")


def means(values):
    rings = values[1:21].reshape(5, 4, 3).mean(axis=1)
    return np.concatenate([rings, values[21:].mean(axis=0, keepdims=True)])


def frames(x):
    tangent, normal = np.empty((2, SECTIONS, 3))
    section_frames(np.ascontiguousarray(x), tangent, normal)
    return tangent, normal


def water_momentum(sections, x, v):
    """Momentum of the water with the body, as the solver counts it: normals one step ago."""
    normal = frames(x - STEP * v)[1]
    along = np.einsum("ki,ki->k", means(v), normal)
    return np.asarray((sections.added * along) @ normal)


def shed(sections, x, v):
    """Momentum per time that leaves at the edge of the tail."""
    tangent, normal = frames(x)
    w, u = means(v)[-1] @ normal[-1], means(v)[-1] @ tangent[-1]
    return np.asarray(sections.flux[-1] * (u * w * normal[-1] - 0.5 * w * w * tangent[-1]))


def moving(body, seed):
    random = np.random.default_rng(seed)
    return (
        body.rest + random.normal(0, 0.05, (NODES, 3)),
        np.array([3.0, 0.0, 0.0]) + random.normal(0, 0.5, (NODES, 3)),
    )


def test_added_mass_is_that_of_the_cone_frustum(slender):
    """∫ ¼πρb² of linear b is that of a frustum: π l (b0² + b0 b1 + b1²) / 12."""
    sections = make_sections(slender)
    b, length = np.array([0.0, *slender.section_heights]), np.diff(slender.stations)
    frusta = np.pi * length * (b[:-1] ** 2 + b[:-1] * b[1:] + b[1:] ** 2) / 12
    assert sections.added.sum() == pytest.approx(frusta.sum())
    assert sections.flux[-1] == pytest.approx(np.pi / 4 * b[-1] ** 2)


def test_body_and_water_keep_their_momentum_but_for_drag_and_wake(slender):
    """Momentum that body and water lose in a step leaves at the tail's edge, to rounding."""
    plan = msgspec.structs.replace(slender, skin_drag=0.0, cross_drag=0.0)
    body = build_body(plan)
    state = at_rest(body)
    state.x[:], state.v[:] = moving(body, 1)
    muscles, none = body.length[None, :12].copy(), np.zeros((NODES, 3))
    for _ in range(20):
        x, v = state.x.copy(), state.v.copy()
        before = body.mass @ v + water_momentum(body.sections, x, v)
        advance(state.x, state.v, body.material, muscles, STILL, none, STEP, state.watch)
        after = body.mass @ state.v + water_momentum(body.sections, state.x, state.v)
        np.testing.assert_allclose(
            after - before, -STEP * shed(body.sections, x, v), atol=1e-9 * np.abs(before).max()
        )


@given(st.integers(0, 2**32 - 1))
def test_the_force_turns_with_the_body_and_ignores_a_common_current(seed):
    random = np.random.default_rng(seed)
    plan = BodyPlan(
        stations=(0.0, 2.1, 6.2, 10.6, 14.4, 17.5, 20.5),
        half_widths=(0.47, 0.88, 0.98, 0.78, 0.69),
        half_heights=(0.55, 1.1, 1.35, 1.38, 1.2),
        tail_half_height=2.0,
        masses=(1.1, 6.6, 11.0, 6.6, 1.1, 1.1, 0.165),
        water="elongated",
    )
    body = build_body(plan)
    x, v = moving(body, seed)
    turn, current = Rotation.random(random_state=random.integers(2**31)), random.normal(0, 2, 3)

    def force(x, v, water):
        v = np.ascontiguousarray(v)  # not the columns of a rotation
        tangent, normal = frames(x)
        load = np.zeros((30, 3))
        before = frames(x - STEP * (v - water))[1]
        resistance = np.empty(SECTIONS)
        axes = np.array([tangent, normal, before])
        add_section_forces(v, water, body.sections, ALL_KEPT, STEP, axes, load, resistance)
        # The implicit part at the old velocity completes the force.
        along = np.einsum("ki,ki->k", means(v), normal)
        total: Floats = load.sum(axis=0) - (resistance * along) @ normal
        return total

    here = force(x, v, STILL)
    np.testing.assert_allclose(force(x, v + current, current), here, atol=1e-8)
    np.testing.assert_allclose(
        force(turn.apply(x), turn.apply(v), STILL), turn.apply(here), atol=1e-8
    )


def test_a_rigid_body_at_an_angle_feels_the_lift_of_a_slender_wing(slender):
    """Lift of a straight body in steady motion is the shed momentum ¼πρb² u w (Jones 1946)."""
    plan = msgspec.structs.replace(slender, skin_drag=0.0, cross_drag=0.0)
    body = build_body(plan)
    tangent, normal = frames(body.rest)
    u, w = 4.0, 0.3
    v = np.tile(u * tangent[0] + w * normal[0], (NODES, 1))
    load = np.zeros((30, 3))
    resistance, axes = np.empty(SECTIONS), np.array([tangent, normal, normal])
    add_section_forces(v, STILL, body.sections, ALL_KEPT, STEP, axes, load, resistance)
    along = np.einsum("ki,ki->k", means(v), normal)
    total = load.sum(axis=0) - (resistance * along) @ normal
    edge = np.pi / 4 * plan.section_heights[-1] ** 2
    np.testing.assert_allclose(total @ normal[0], -edge * u * w, rtol=1e-12)
    np.testing.assert_allclose(total @ tangent[0], 0.5 * edge * w * w, rtol=1e-12)


def test_a_gliding_body_slows_as_skin_drag_says(slender):
    """m dU/dt = -½ρSC U|U| gives U = U0 / (1 + U0 t ½ρSC / m)."""
    body = build_body(slender)
    state = at_rest(body)
    state.v[:, 0] = start = 4.0
    ticks = 90
    simulate(body, state, np.zeros((6 * ticks, 12)))
    rate = body.sections.skin.sum() / body.mass.sum()
    expected = start / (1.0 + start * rate * ticks * 6 * STEP)
    assert body.mass @ state.v[:, 0] / body.mass.sum() == pytest.approx(expected, rel=0.02)


def test_a_prescribed_wave_gives_lighthills_thrust(slender):
    """A travelling wave has mean thrust ½ m (⟨W²⟩ - U²⟨h'²⟩) at the tail's edge (Lighthill)."""
    sections = make_sections(msgspec.structs.replace(slender, skin_drag=0.0, cross_drag=0.0))
    body = build_body(slender)
    length, speed = slender.length, 4.0
    wave, omega, amplitude = 2 * np.pi / length, 2 * np.pi * 0.3, 0.02

    def nodes(t):
        x = body.rest.copy()
        x[:, 0] += speed * t
        behind = -body.rest[:, 0]
        x[:, 2] += amplitude * np.sin(wave * behind - omega * t)
        v = np.zeros((NODES, 3))
        v[:, 0] = speed
        v[:, 2] = -omega * amplitude * np.cos(wave * behind - omega * t)
        return x, v

    step = 1e-3
    times = np.arange(0.0, 2 * np.pi / omega, 20 * step)
    thrust = []
    for t in times:
        x, v = nodes(t)
        tangent, normal = frames(x)
        load = np.zeros((30, 3))
        resistance, axes = np.empty(SECTIONS), np.array([tangent, normal, normal])
        add_section_forces(v, STILL, sections, ALL_KEPT, step, axes, load, resistance)
        # The flux alone: without the momentum that the implicit part gives back.
        along = np.einsum("ki,ki->k", means(v), normal)
        held = (sections.added / step * along) @ normal
        thrust.append((load.sum(axis=0) - held)[0])
    slope, rise = wave * amplitude, omega * amplitude
    expected = 0.5 * sections.flux[-1] * 0.5 * (rise**2 - (speed * slope) ** 2)
    # The section's tangent is a chord over the last interval, an error of second order.
    assert np.mean(thrust) == pytest.approx(expected, rel=0.12)


def test_half_the_step_gives_the_same_swim(slender):
    plan = msgspec.structs.replace(
        slender, muscle_stiffness=150.0, cross_stiffness=80.0, other_stiffness=80.0,
        masses=(1.1, 6.6, 11.0, 6.6, 3.3, 2.2, 0.66),
    )  # fmt: skip
    body = build_body(plan)
    way = []
    for parts in (1, 2):
        steps = 6 * 60 * parts
        phase = 2 * np.pi * np.arange(steps) / (6 * 20 * parts)
        left = np.tile([1.0, -1.0, -1.0, 1.0], 3)
        contraction = 0.05 * (1 + np.sin(phase)[:, None] * left)
        state = at_rest(body)
        simulate(body, state, contraction, step=STEP / parts)
        way.append(body.mass @ state.x / body.mass.sum())
    assert way[0][0] > 1.0
    np.testing.assert_allclose(way[0], way[1], atol=0.05 * way[0][0])


# Lighthill 1971, table 1: edge of the tail of a swimming dace (Bainbridge 1963), SI units.
DACE = np.array([
    # V, height, α (°), α + θ (°), m w W - ½ m w² ∂x/∂a
    (0.50, 0.094, 3, 17, 0.03),
    (0.60, 0.087, 3, 45, 0.07),
    (0.74, 0.079, 5, 60, 0.18),
    (0.68, 0.083, 16, 48, 0.43),
    (0.52, 0.087, 10, 13, 0.04),
    (0.62, 0.088, -8, -36, 0.17),
    (0.87, 0.083, -16, -60, 0.86),
    (0.67, 0.084, -10, -46, 0.29),
    (0.52, 0.092, -6, -25, 0.07),
    (0.48, 0.093, 0, -3, 0.00),
])  # fmt: skip


def test_the_tail_of_a_dace_pushes_as_in_lighthills_table(slender):
    thrust = []
    for speed, height, alpha, heading, _ in DACE:
        spans = (*slender.section_heights[:-1], 100 * height)
        plan = msgspec.structs.replace(slender, skin_drag=0.0, cross_drag=0.0, spans=spans)
        body = build_body(plan)
        lean, way = np.radians(heading - alpha), np.radians(heading)
        x = Rotation.from_rotvec([0.0, -lean, 0.0]).apply(body.rest)
        v = np.tile(10.0 * speed * np.array([np.cos(way), 0.0, np.sin(way)]), (NODES, 1))
        tangent, normal = frames(x)
        load = np.zeros((30, 3))
        resistance, axes = np.empty(SECTIONS), np.array([tangent, normal, normal])
        add_section_forces(v, STILL, body.sections, ALL_KEPT, STEP, axes, load, resistance)
        along = np.einsum("ki,ki->k", means(v), normal)
        held = (body.sections.added / STEP * along) @ normal
        thrust.append(1e-3 * (load.sum(axis=0) - held)[0])  # g cm/tu² is 1e-3 N
    # The angles are printed in whole degrees: a half of one is a sixth of the smallest.
    np.testing.assert_allclose(thrust, DACE[:, 4], atol=0.04, rtol=0.1)
    assert np.mean(thrust) == pytest.approx(0.21, abs=0.02)


def test_a_body_four_times_as_stiff_swims_the_same_path_in_half_the_time(slender):
    """The pace of a species: forces of water are quadratic in speed, those of muscles elastic."""
    quick = msgspec.structs.replace(
        slender, viscosity=2 * slender.viscosity,
        **{f"{kind}_stiffness": 4 * getattr(slender, f"{kind}_stiffness")
           for kind in ("muscle", "cross", "other")},
    )  # fmt: skip
    phase = 2 * np.pi * np.arange(6 * 40) / (6 * 20)
    contraction = 0.1 * (1 + np.sin(phase)[:, None] * np.tile([1.0, -1.0, -1.0, 1.0], 3))
    paths = []
    for plan, step in ((slender, STEP), (quick, STEP / 2)):
        body = build_body(plan)
        paths.append(simulate(body, at_rest(body), contraction, step=step))
    np.testing.assert_allclose(paths[0], paths[1], atol=1e-8)
