import numpy as np
import pytest

from subsea.biomechanics.body import LOWER_TAIL, MUSCLES, UPPER_TAIL, build_body
from subsea.biomechanics.simulation import at_rest, is_sound, simulate
from subsea.biomechanics.solver import STEP, check_step, longest_step
from subsea.fish.species import load_species, muscular_names


@pytest.mark.parametrize("name", ["tu", *muscular_names()])
def test_a_kicked_body_settles_below_the_limit_and_bursts_above(name, fusilier):
    """Water holds a growing mode down above the limit, that of slender bodies for long."""
    plan = fusilier.body if name == "tu" else load_species(name).body
    assert plan
    body = build_body(plan)
    limit = longest_step(body)[0]

    def sound(step):
        state = at_rest(body)
        state.v[:] = np.random.default_rng(1).normal(0, 0.2, (23, 3))
        simulate(body, state, np.zeros((1200, MUSCLES)), step=step)
        return is_sound(state)

    assert sound(0.97 * limit)
    assert not sound((1.12 if name == "tu" else 1.6) * limit)


def test_the_limit_of_two_masses_on_a_spring(fusilier):
    """All units but one without stiffness or damping: ω² = 2 k/m, and h² ω² + 2 h (2 c/m) = 4."""
    body = build_body(fusilier.body)
    body.mass[:] = 3.0
    body.stiffness[1:] = 0.0
    body.viscosity[1:] = 0.0
    k, c = 2 * body.stiffness[0] / 3.0, 2 * body.viscosity[0] / 3.0
    step = longest_step(body)[0]
    assert step**2 * k + 2 * step * c == pytest.approx(4.0)


def test_the_node_that_limits_is_the_light_one(fusilier):
    body = build_body(fusilier.body)
    assert longest_step(body)[1] in (UPPER_TAIL, LOWER_TAIL)
    body.mass[7] = 0.01
    assert longest_step(body)[1] == 7


def test_the_check_agrees_with_the_limit(species):
    assert longest_step(build_body(species.body))[0] > STEP
    check_step(species.body)
