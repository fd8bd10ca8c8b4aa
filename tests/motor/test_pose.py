"""The pose between two ticks."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.motor.pose import centres_world, nodes_world, pose_at
from subsea.state import Fishes, empty


def _fish(before, after):
    """One fish whose pose was (a, b, weight, span) and is now another."""
    fishes = empty(Fishes, n=1)
    for prefix, pose in (("previous_", before), ("", after)):
        for name, value in zip(("row_a", "row_b", "weight", "span"), pose, strict=True):
            getattr(fishes, prefix + name)[0] = value
    return fishes


CASES = [
    ((3, 4, 0.2, 1), (3, 4, 0.9, 1)),  # inside a row
    ((3, 4, 0.2, 1), (4, 5, 0.3, 1)),  # into the next
    ((3, 4, 0.8, 1), (5, 6, 0.5, 1)),  # a quick fish passes one ...
    ((9, 10, 0.8, 1), (2, 3, 0.5, 1)),  # ... or four, over the end of a cycle
    ((3, 4, 0.5, 1), (4, 21, 0.1, 5)),  # a glide begins
    ((4, 21, 0.9, 5), (21, 22, 0.5, 1)),  # and ends
]


@pytest.mark.parametrize(("before", "after"), CASES)
def test_the_ends_are_the_ticks(library, before, after):
    fishes = _fish(before, after)
    assert pose_at(fishes, library, 0, 0.0) == pytest.approx(before[:3], abs=1e-6)
    a, b, w = pose_at(fishes, library, 0, 1.0)
    end = {a: 1 - w, b: w}
    for row, weight in ((after[0], 1 - after[2]), (after[1], after[2])):
        assert end.get(row, 0.0) == pytest.approx(weight, abs=1e-6)


@pytest.mark.parametrize(("before", "after"), CASES)
@given(alpha=st.floats(0, 0.999))
def test_the_pose_flows_without_a_leap(library, before, after, alpha):
    """A thousandth of a tick later the mix of rows is nearly the same."""
    fishes = _fish(before, after)

    def mix(at):
        a, b, w = pose_at(fishes, library, 0, at)
        out = np.zeros(24)
        out[a] += 1 - w
        out[b] += w
        return out

    assert np.abs(mix(alpha + 0.001) - mix(alpha)).max() < 0.006


def test_between_ticks_a_quick_fish_passes_every_recorded_row(library):
    """At five rows a tick a line from the first to the last would cut half of a beat."""
    fishes = _fish((9, 10, 0.8, 1), (2, 3, 0.5, 1))
    rows = []
    for alpha in np.linspace(0, 1, 1001):
        a, b, _ = pose_at(fishes, library, 0, alpha)
        assert (b - a) % 12 == 1
        if not rows or rows[-1] != a:
            rows.append(a)
    assert rows == [9, 10, 11, 0, 1, 2]


def test_the_centre_of_mass_is_the_mean_of_the_nodes_by_their_masses(make_tank):
    """Against the nodes of each fish in the world, in a bent glide; without masses all alike."""
    tank = make_tank("blue_tang", 1.5)
    tank.put("turn_left_gradual", 7).step(3)
    fishes = tank.fishes
    nodes = nodes_world(fishes, tank.library, 0)
    mass = tank.dynamics.bodies.mass
    expected = mass[0] @ nodes / mass[0].sum()
    assert centres_world(fishes, tank.library.nodes, mass)[0] == pytest.approx(expected, abs=1e-4)
    alike = centres_world(fishes, tank.library.nodes, 0.0 * mass)[0]
    assert alike == pytest.approx(nodes.mean(axis=0), abs=1e-4)
