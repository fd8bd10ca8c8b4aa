"""Simulated fishes: the kernel against the plain simulation, and the response to goals."""

from itertools import product

import msgspec
import numpy as np
import pytest

from subsea.biomechanics.body import UNITS, body_frame, build_body
from subsea.biomechanics.body_plan import GRADES, MAX_CONTRACTION
from subsea.biomechanics.controllers import (
    LEFT,
    RIGHT,
    bend_contraction,
    muscle_lengths,
    swim_contraction,
)
from subsea.biomechanics.fins import balance, pectoral_force
from subsea.biomechanics.simulation import BodyState, simulate
from subsea.biomechanics.solver import STEPS_PER_TICK, STRAIN_LIMITS
from subsea.fish.species import load_species, muscular_names
from subsea.geometry.rotation import about, from_matrix, matrix, multiply
from subsea.motor.containment import roll_of
from subsea.motor.controller import MAX_PITCH_RAD, ROW_PITCH_RAD
from subsea.motor.dynamics import (
    SCULL_SPEED,
    Integration,
    contract,
    fin_force,
    flow_along,
    frame_of,
    pitching_force,
    roll_rate,
    spread_force,
    swim_live,
)
from subsea.motor.playback import BASE, COAST, ROW
from tests.support.daily import only

TICK = 0.033
STILL = np.zeros(3)
KIND = np.uint8(0)  # of the only species of a tank, in the type of `Fishes.species`
USUAL = Integration(TICK, 1.0, 6, STRAIN_LIMITS, np.zeros((1, 2, 3)))

every_species = pytest.mark.parametrize("species", muscular_names())
# Swims of minutes: by day three fishes of unlike bodies.
unlike_species = pytest.mark.parametrize(
    "species", only(("blacktip_reef_shark", "fusilier"), muscular_names())
)


def _live(make_tank, species, name="swim_fast", ticks=28):
    """A simulated fish that cruises; at lower speeds some species row, and are played back."""
    tank = make_tank(species).put(name)
    tank.to_live()
    tank.run(ticks)
    return tank


def _travel(tank, before, ticks):
    """The way (3,), cm, in a number of ticks after others."""
    tank.run(before)
    begin = tank.fishes.position[0].copy()
    tank.run(ticks)
    return tank.fishes.position[0] - begin


def _geared(swim, gear, phase):
    """Contractions (T, 12) of a beat: those of a grade, or between those of two grades."""
    whole = {1: swim.at("slow"), 2: swim.at("medium"), 3: swim}
    if gear in whole:
        return swim_contraction(whole[gear], phase, swim.amplitude(GRADES[int(gear) - 1]))
    lower, upper = int(gear), int(gear) + 1
    share = gear - lower
    low, high = (swim.amplitude(GRADES[one - 1]) for one in (lower, upper))
    parts = np.outer((1 - share) * low, whole[lower].contraction)
    parts += np.outer(share * high, whole[upper].contraction)
    lag = (1 - share) * whole[lower].lag + share * whole[upper].lag
    between = msgspec.structs.replace(swim, contraction=tuple(parts[0]), lag=lag)
    return swim_contraction(between, phase)


@every_species
@pytest.mark.parametrize("gear", [1, 2, 2.4, 3])
def test_muscles_contract_as_the_plain_controllers_say(make_tank, species, gear):
    plan = load_species(species)
    bodies = make_tank(species).dynamics.bodies
    bend = plan.turn.gradual
    for side, phase in product((LEFT, RIGHT), np.linspace(0.0, 6.0, 7)):
        lengths = np.empty(12)
        contract(bodies, KIND, phase, float(gear), side * np.array(bend), lengths)
        contraction = _geared(plan.swim, gear, phase) + bend_contraction(bend, side)
        expected = muscle_lengths(build_body(plan.body), np.minimum(contraction, MAX_CONTRACTION))[
            0
        ]
        np.testing.assert_allclose(lengths, expected, rtol=1e-12, err_msg=f"{side}, {phase}")


@every_species
def test_a_tick_is_six_steps_of_the_plain_simulation(make_tank, species):
    tank = _live(make_tank, species)
    plan = load_species(species)
    live = tank.live
    none = np.zeros(1)
    bodies = tank.dynamics.bodies._replace(
        fin_area=none, pitching=none, median_area=none, pelvic_area=none
    )
    state = BodyState(live.x[0].copy(), live.v[0].copy(), np.array([np.inf, 0.0, np.inf]))
    begin = live.phase[0]
    assert live.fish[0] == 0
    assert swim_live(tank.fishes, tank.library, bodies, live, USUAL)[0]
    # The kernel eases gear, tempo and bend first, then holds them for the tick.
    beat = 2 * np.pi / (plan.swim.ticks_per_beat * STEPS_PER_TICK) * live.tempo[0]
    steps = beat * np.arange(STEPS_PER_TICK)
    contraction = _geared(plan.swim, live.gear[0], begin + steps)
    contraction += bend_contraction(tuple(np.abs(live.bend[0])), np.sign(live.bend[0, 0]))
    simulate(build_body(plan.body), state, contraction)
    origin = body_frame(state.x)[0]
    # Both are rounded to float32.
    np.testing.assert_allclose(live.x[0], state.x - origin, rtol=1e-7, atol=1e-6)
    np.testing.assert_allclose(live.v[0], state.v, rtol=1e-7, atol=1e-6)


def test_the_compiled_frame_is_the_body_frame(make_tank):
    nodes = _live(make_tank, "fusilier", "swim_fast").live.x[0] + [3.0, -2.0, 1.0]
    q, o = frame_of(nodes)
    origin, rotation = body_frame(nodes)
    np.testing.assert_allclose(o, origin, atol=1e-12)
    expected = from_matrix(rotation)
    np.testing.assert_allclose(np.array(q) * np.sign(q @ expected), expected, atol=1e-12)


@pytest.mark.parametrize("roll", [-0.2, 0.05, 0.3])
def test_fins_push_as_the_plain_ones_do(make_tank, roll):
    """At SCULL_SPEED, level and without oscillation, the fins act as in balance, without pitch."""
    tank = make_tank("fusilier").put("swim_medium")
    fishes, bodies = tank.fishes, tank.dynamics.bodies
    upright = tuple(fishes.orientation[0].astype(float))
    turned = multiply(upright, about(1.0, 0.0, 0.0, roll))
    fishes.orientation[0] = fishes.previous_orientation[0] = turned
    R = matrix(np.array(turned))
    v = np.tile(SCULL_SPEED * R[:, 0], (23, 1))
    # Upwards is z in the world, and y in a simulation.
    to_y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    rest = build_body(load_species("fusilier").body).rest
    state = BodyState(rest @ R.T @ to_y.T, v @ to_y.T, np.zeros(3))
    left, right = balance(state)
    tilt = 0.5 * (left - right)
    fins = np.pi / 2 + tilt, np.pi / 2 - tilt
    expected = pectoral_force(state, bodies.fin_area[0], *fins, STILL)
    force = fin_force(bodies, KIND, rest @ R.T, v, 0.0) @ to_y.T
    np.testing.assert_allclose(force, expected, atol=1e-3 * np.abs(expected).max())


def test_spread_median_fins_resist_sway_and_yaw_and_pelvic_fins_brake(make_tank):
    """Half of the sway costs a quarter of the force; folded fins cost none."""
    tank = make_tank("emperor_angelfish").put("swim_medium")
    bodies, x = tank.dynamics.bodies, build_body(load_species("emperor_angelfish").body).rest
    ahead, right = np.eye(3)[[0, 2]]
    sway = np.tile(2.0 * right, (23, 1))
    turning = np.cross([0.0, 0.3, 0.0], x)
    none, half, whole = np.float32([0.0, 0.5, 1.0])
    forces = [spread_force(bodies, KIND, x, v, whole, none) for v in (sway, sway / 2, turning)]
    push = [force.sum(axis=0) @ right for force in forces]
    assert push[0] < 0.0 and push[0] == pytest.approx(4.0 * push[1])
    assert push[0] == pytest.approx(-bodies.median_area[0] * 4.0)
    assert np.cross(x, forces[2]).sum(axis=0)[1] < 0.0
    assert not spread_force(bodies, KIND, x, sway, none, whole).any()
    brake = spread_force(bodies, KIND, x, np.tile(3.0 * ahead, (23, 1)), none, half)
    np.testing.assert_allclose(brake.sum(axis=0), -4.5 * bodies.pelvic_area[0] * ahead, atol=1e-9)
    # Both are small beside the drag of the body: some hundredths of the squared length.
    areas = np.array([bodies.median_area[0], bodies.pelvic_area[0]]) / 24.0**2
    assert (areas > 0.005).all() and (areas < 0.1).all()


@unlike_species
def test_it_swims_about_as_fast_as_it_is_asked_to(make_tank, species):
    """At full speed it may be slower, as muscles at their limit cannot make up for turns.

    Without oars it coasts for long until it is as slow as a sixth of its fast swim.
    """
    for speed in (0.15, 0.3, 0.45, 0.6, 0.8, 1.0):
        tank = _live(make_tank, species)
        tank.aim(0.0, speed)
        # Drag slows a slow fish for long.
        before, ticks = (200, 140) if speed > 0.4 else (400, 600)
        measured = np.linalg.norm(_travel(tank, before, ticks)) / (ticks * TICK)
        least, most = 0.75 if speed > 0.9 else 0.83, 1.1 if speed > 0.2 else 1.4
        assert least < measured / (speed * tank.library.speed[0, 2]) < most, speed


@pytest.mark.parametrize("species", ["blacktip_reef_shark", "fusilier"])
def test_it_does_not_waver_between_beat_and_coast(make_tank, species):
    """The body swings on when a beat ends: what counts is the speed of its centre of mass."""
    tank = _live(make_tank, species)
    tank.aim(0.0, 0.45)
    tank.run(200)
    coasts = []
    for _ in range(300):
        tank.run(1)
        coasts.append(BASE[tank.fishes.wanted_segment[0]] == COAST)
    begun = (np.diff(np.array(coasts, int)) > 0).sum()
    assert 3 <= begun < 1.2 * 300 * TICK


@pytest.mark.nightly
@unlike_species
def test_every_heading_is_reached_and_held(make_tank, species):
    for azimuth in (-170, -90, -30, 10, 35, 60, 100, 179):
        tank = _live(make_tank, species)
        tank.aim(np.radians(azimuth), 0.6)
        way = _travel(tank, 420, 112)
        gap = np.degrees(np.arctan2(way[1], way[0])) - azimuth
        assert abs((gap + 180) % 360 - 180) < 6, (azimuth, gap)


@unlike_species
def test_fins_climb_and_dive(make_tank, species):
    for climb, speed in ((-60, 0.3), (-20, 0.8), (20, 0.3), (35, 0.8)):
        tank = _live(make_tank, species)
        tank.aim(0.0, speed, np.radians(climb))
        way = _travel(tank, 300, 56)
        angle = np.degrees(np.arcsin(way[2] / np.linalg.norm(way)))
        rows = BASE[tank.fishes.wanted_segment[0]] == ROW
        steepest = np.degrees(ROW_PITCH_RAD if rows else MAX_PITCH_RAD)
        # Slow water gives fins the less hold; the tang sways from side to side and is slower.
        near = 11 if speed < 0.5 or species == "blue_tang" else 7
        assert angle == pytest.approx(np.clip(climb, -steepest, steepest), abs=near), climb


@unlike_species
def test_a_rolled_fish_rights_itself(make_tank, species):
    """As far as it does not lean into turns, as it did when it was recorded."""
    for speed in (0.1, 0.3, 0.6, 1.0):
        tank = make_tank(species).put("swim_medium")
        upright = tuple(tank.fishes.orientation[0].astype(float))
        tank.fishes.orientation[0] = multiply(upright, about(1.0, 0.0, 0.0, np.radians(40.0)))
        tank.to_live()
        tank.aim(0.0, speed)
        tank.run(240)
        rolls = []
        for _ in range(60):
            tank.run(1)
            rolls.append(roll_of(tuple(tank.fishes.orientation[0].astype(float))))
        lean = np.abs(tank.library.bank).max()
        assert np.abs(rolls).max() < np.radians(10.0) + lean, speed


@every_species
def test_asked_to_stop_it_stops(make_tank, species):
    tank = _live(make_tank, species)
    cruise = np.linalg.norm(tank.fishes.velocity[0])
    tank.aim(0.0, 0.0)
    assert np.linalg.norm(_travel(tank, 200, 30)) / (30 * TICK) < 0.15 * cruise


def test_a_larger_fish_beats_more_slowly(make_tank):
    """A fish α times as long makes the same motion, α times as large, at 1/√α of the pace."""
    paths = []
    for scale in (1.0, 4.0):
        tank = make_tank("fusilier", scale).put("swim_fast")
        tank.to_live()
        path = tank.step(int(28 * scale**0.5), obey=False)
        paths.append((path[-1] - path[0]) / scale)
    np.testing.assert_allclose(paths[1], paths[0], atol=0.08 * 20)


def test_a_current_carries_it_along(make_tank):
    still, carried = (make_tank("fusilier").put("swim_slow") for _ in range(2))
    flow = np.array([3.0, -5.0, 0.0])
    for tank in (still, carried):
        tank.to_live()
    carried.fishes.drift[:] = flow
    for _ in range(60):
        for tank in (still, carried):
            swim_live(tank.fishes, tank.library, tank.dynamics.bodies, tank.live, USUAL)
    gap = carried.fishes.position[0] - still.fishes.position[0]
    np.testing.assert_allclose(gap, 60 * TICK * flow, atol=1e-3)


@pytest.mark.parametrize("rate", [0.0, 0.3, -1.2])
def test_the_rate_of_roll_of_a_body_that_rolls_and_beats(rate):
    """Detect a stiff roll about any axis; a beat, equal above and below, has no roll."""
    rng = np.random.default_rng(8)
    body = build_body(load_species("fusilier").body)
    axis = np.array([0.6, 0.0, 0.8])
    drift = rng.normal(0, 1, 3)
    stiff = drift + rate * np.cross(axis, body.rest - rng.normal(0, 1, 3))
    assert roll_rate(body.rest, stiff, body.mass, tuple(axis)) == pytest.approx(rate)
    beat = np.zeros((23, 3))
    beat[:, 2] = np.sin(body.rest[:, 0])
    assert roll_rate(body.rest, beat, body.mass, (1.0, 0.0, 0.0)) == pytest.approx(0.0, abs=1e-12)


def _heading_and_pitch(tank):
    """The smoothed heading and the pitch of a simulated fish, degrees."""
    ahead = matrix(tank.fishes.orientation[0].astype(float))[:, 0]
    return np.degrees((tank.live.course[0], np.arcsin(ahead[2])))


@pytest.mark.parametrize("axis", [1, 2])
def test_water_that_shears_along_the_body_turns_it_and_it_recovers(make_tank, axis):
    """A gust from the left, or from below, meets the snout and passes over the tail."""
    tank = _live(make_tank, "fusilier", ticks=60)
    mass, answer, energy = tank.dynamics.bodies.mass[0], [], []
    for tick in range(300):
        tank.shear[0, :, axis] = (6.0, -6.0) if tick < 40 else (0.0, 0.0)
        tank.run(1)
        answer.append(_heading_and_pitch(tank)[axis - 1])
        energy.append(0.5 * mass @ (tank.live.v[0] ** 2).sum(axis=1))
    assert tank.fishes.live[0]
    assert 10.0 < max(answer[:60]) < 90.0
    assert np.abs(answer[-30:]).max() < 3.0
    assert max(energy) < 3.0 * np.mean(energy[-30:])


def test_the_flow_along_a_body_has_the_values_of_the_tips_and_no_strain_by_its_slope():
    body = build_body(load_species("fusilier").body)
    x = body.rest @ matrix(np.array([0.8, 0.2, -0.4, 0.4])).T + [3.0, -2.0, 1.0]
    q, origin = frame_of(x)
    ahead = matrix(np.array(q))[:, 0]
    flow, (snout, tail) = np.empty((23, 3)), (x[[0, 21]] - origin) @ ahead
    tips = np.array([[2.0, 1.0, -3.0], [-1.0, 4.0, 0.5]])
    across = tips - (tips @ ahead)[:, None] * ahead
    flow_along(x, tips, flow)
    np.testing.assert_allclose(flow[0], across[0], atol=1e-9)
    np.testing.assert_allclose(flow[[21, 22]].mean(axis=0), across[1], atol=0.1)
    slope = np.array([snout, tail])[:, None] * np.cross(ahead, tips[0])
    flow_along(x, slope, flow)
    i, j = UNITS.T
    stretch = ((x[j] - x[i]) * (flow[j] - flow[i])).sum(axis=1)
    np.testing.assert_allclose(stretch, 0.0, atol=1e-9)


@every_species
def test_muscles_alone_turn_it_and_fins_pitch_it_no_harder_than_they_lift(make_tank, species):
    """No couple acts about the vertical of a level fish; the other one is within the fins' lift."""
    tank = _live(make_tank, species)
    bodies, x, v = tank.dynamics.bodies, tank.live.x[0].copy(), tank.live.v[0]
    x -= bodies.inertia[0] @ x / bodies.inertia[0].sum()
    _, _, across = matrix(np.array(frame_of(x)[0])).T
    for rate in (0.5, -0.5):
        couple = np.cross(x, pitching_force(bodies, KIND, x, v, rate)).sum(axis=0)
        arms = np.cross(across, x)
        speed = np.linalg.norm(v[1:13].mean(axis=0))
        most = bodies.pitching[0] * speed**2
        assert couple @ across / (bodies.inertia[0] @ (arms**2).sum(axis=1)) == pytest.approx(
            np.sign(rate) * most
        )
        assert most < 0.02
