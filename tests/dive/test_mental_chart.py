"""The chart of a fish's mental state holds the values of the state."""

from types import SimpleNamespace

import numpy as np

from subsea.dive.minds_text import SPAN, Chart


def world_at(tick):
    mental = np.array([[0, 0, 0], [tick, 2 * tick, 3 * tick]], np.float32) / 1e4
    minds = SimpleNamespace(mental=mental)
    return SimpleNamespace(state=SimpleNamespace(tick=tick, minds=minds))


def followed(ticks):
    chart = Chart(1)
    for tick in ticks:
        chart.follow(world_at(tick))
    return chart


def test_it_holds_a_value_of_every_tick_up_to_a_minute():
    values = followed(range(100, 2500)).values
    assert values.shape == (3, SPAN)
    expected = np.arange(2500 - SPAN, 2500) / 1e4
    np.testing.assert_allclose(values, [expected, 2 * expected, 3 * expected], rtol=1e-6)


def test_ticks_without_a_picture_count_as_the_next_one():
    values = followed([10, 13, 14]).values
    np.testing.assert_allclose(values[0] * 1e4, [10, 13, 13, 13, 14], rtol=1e-5)


def test_values_after_a_rewind_are_dropped():
    values = followed([*range(10, 30), 15, 16]).values
    np.testing.assert_allclose(values[0] * 1e4, range(10, 17), rtol=1e-5)


def test_a_long_gap_clears_the_chart():
    assert followed([10, 11, 500]).values.shape == (3, 1)
    assert followed([500, 501, 10]).values.shape == (3, 1)


def test_values_are_a_view():
    chart = followed(range(50))
    assert chart.values.base is chart.values[0].base is not None
    assert chart.values[0].flags.c_contiguous
