"""Drag of glides and the Strouhal number that balances it."""

import numpy as np
import pytest

from capture.inspection.report import (
    SWIMMING_DRAG,
    drag_coefficient,
    expected_strouhal,
    glide,
    glide_drag,
    strouhal_of_drag,
    wetted_area,
)
from capture.recording.record import motion_of
from subsea.fish.species import load_species


def test_drag_of_a_quadratic_glide():
    """U = U0 / (1 + k U0 t) with k = ρ S C_D / 2 m; means over ticks."""
    mass, area, drag, tick = 30.0, 160.0, 0.024, 0.33
    k = area * drag / (2 * mass)
    time = tick * np.arange(200)
    way = np.log1p(k * 4.0 * time) / k
    speeds = np.concatenate([[4.0], np.diff(way) / tick])
    assert drag_coefficient(speeds, tick, mass, area) == pytest.approx(drag, rel=1e-3)


def test_drag_of_a_simulated_glide_hardly_depends_on_its_speed():
    species = load_species("fusilier")
    motion = motion_of(species)
    speeds = glide(motion, 4.0)
    assert (np.diff(speeds) < 0).all()
    slow, fast = (glide_drag(motion, species.surface, speed) for speed in (2.0, 4.0))
    assert 0.003 < fast < 0.05
    assert slow == pytest.approx(fast, rel=0.5)


def test_the_design_formula():
    """The two examples: S = 0.4 L², b = 0.2 L, β = 0.7."""
    assert strouhal_of_drag(0.010, 0.4 / 0.04) == pytest.approx(0.225, abs=1e-3)
    assert strouhal_of_drag(0.020, 0.4 / 0.04) == pytest.approx(0.318, abs=1e-3)


def test_small_fishes_need_a_higher_strouhal_number():
    surface = load_species("fusilier").surface
    small, large = (expected_strouhal(surface, cm, 2 * cm) for cm in (4.0, 40.0))
    assert small == pytest.approx(large * 10**0.5, rel=1e-6)  # laminar: Re^-1/4 in St
    assert SWIMMING_DRAG > 1
    assert 0.3 < wetted_area(surface) < 0.6
