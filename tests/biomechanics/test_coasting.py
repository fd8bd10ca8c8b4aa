"""Bodies that no tail drives: coasts, straight and bent, and turns by one pectoral fin."""

from functools import cache

import msgspec
import numpy as np
import pytest

from subsea.biomechanics.body import build_body
from subsea.biomechanics.coasting import coast, row_turn
from subsea.biomechanics.fins import headings
from subsea.biomechanics.manoeuvres import body_bend
from subsea.biomechanics.rowing import hull_drag, oars_of
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK
from subsea.biomechanics.trial import displacement, loop_error
from subsea.fish.species import load_species


@cache
def _coast(species, turns, medium=1.0):
    muscles = load_species(species).muscles
    return coast(muscles._replace(swim=msgspec.structs.replace(muscles.swim, medium=medium)), turns)


@cache
def _row_turn(species):
    plan = load_species(species)
    fin, length = plan.surface.pectoral, plan.muscles.body.length
    size = fin.length * length, fin.width * length
    oars = oars_of(build_body(plan.muscles.body), plan.row, size)
    return row_turn(plan.muscles, oars, plan.row.ticks_per_stroke)


def _radius(trial, length):
    """Distance from the middle of the circle, body lengths."""
    turned = np.radians(headings(trial.frames)[-1] - headings(trial.frames)[0])
    return float(np.linalg.norm(displacement(trial.frames))) / turned / length


def test_a_straight_coast_is_straight_and_slowed_by_the_drag_of_the_hull():
    muscles = load_species("fusilier").muscles
    trial, body = _coast("fusilier", False), build_body(muscles.body)
    assert np.abs(body_bend(trial.frames)).max() < 0.1
    assert np.ptp(headings(trial.frames)) < 1e-3
    tick = STEP * STEPS_PER_TICK
    speed = np.linalg.norm(displacement(trial.frames)) / ((len(trial.frames) - 1) * tick)
    expected = hull_drag(body) / body.mass.sum() * speed * tick
    assert trial.slowing == pytest.approx(expected, rel=0.1)


def test_a_bent_coast_turns_to_the_side_it_bends_to_and_is_slowed_more():
    trial = _coast("fusilier", True)
    length = load_species("fusilier").muscles.body.length
    assert 15.0 < body_bend(trial.frames).min() <= body_bend(trial.frames).max() < 60.0
    assert 0.3 < _radius(trial, length) < 2.0
    assert loop_error(trial.frames) < 1e-4 * length
    assert trial.slowing > _coast("fusilier", False).slowing


def test_the_way_of_a_coast_depends_little_on_its_speed():
    """Playback relies on it: the tempo of a coast is its speed. Faster water bends a body more."""
    length = load_species("fusilier").muscles.body.length
    slow, usual = _coast("fusilier", True, 0.6), _coast("fusilier", True)
    ratio = np.linalg.norm(displacement(slow.frames)) / np.linalg.norm(displacement(usual.frames))
    assert ratio < 0.8
    assert _radius(slow, length) == pytest.approx(_radius(usual, length), rel=0.35)
    assert slow.slowing == pytest.approx(ratio * usual.slowing, rel=0.2)


def test_an_outer_fin_turns_a_fish_that_bends_into_the_turn():
    trial = _row_turn("clownfish")
    muscles = load_species("clownfish").muscles
    turned = np.diff(headings(trial.frames))
    assert turned.mean() > 0.5 and turned.max() < 3.0  # degrees a tick
    assert 15.0 < body_bend(trial.frames).min() <= body_bend(trial.frames).max() < 60.0
    assert 0.2 < _radius(trial, muscles.body.length) < 2.0
    assert loop_error(trial.frames) < 1e-4 * muscles.body.length
