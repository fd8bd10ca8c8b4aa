"""Timer queries name the stages that are drawn, and cost nothing while they are off."""

from types import SimpleNamespace

import pytest

from subsea.rendering.gl.context import GPU_STAGES, GpuTimer

SIZE = (64, 36)


@pytest.fixture
def timed(make_renderer):
    """A renderer whose timer is on."""
    renderer = make_renderer(SIZE)
    renderer.timer.on = True
    yield renderer
    renderer.timer.on = False
    renderer.timer.seconds()


def test_each_stage_that_is_drawn_takes_time(timed, make_packet, fish):
    packet = make_packet([fish(0, (0, 40, -200))], size=SIZE)
    for _ in range(2):
        timed.draw(packet)
        spent = timed.timer.seconds()
    assert tuple(spent) == GPU_STAGES
    for name in ("sand", "water", "fishes", "output"):
        assert 0.0 < spent[name] < 5.0, name


def test_the_picture_is_the_same_with_and_without(timed, make_packet, fish):
    packet = make_packet([fish(0, (0, 40, -200))], size=SIZE)
    timed.draw(packet)
    with_queries = timed.read_pixels()
    timed.timer.seconds()
    timed.timer.on = False
    timed.draw(packet)
    assert (timed.read_pixels() == with_queries).all()


def test_queries_are_used_again(timed, make_packet):
    packet = make_packet([], size=SIZE)
    for _ in range(3):
        timed.draw(packet)
        timed.timer.seconds()
    first = len(timed.timer._queries)
    timed.draw(packet)
    timed.timer.seconds()
    assert len(timed.timer._queries) == first


def test_it_measures_nothing_while_it_is_off(context):
    timer = GpuTimer(context)
    with timer.stage("water"):
        context.clear()
    assert set(timer.seconds().values()) == {0.0}


def test_the_next_picture_waits_for_the_one_before_and_knows_its_time(timed, make_packet):
    timed.timer.on = False
    packet = make_packet([], size=SIZE)
    for _ in range(3):  # llvmpipe does not know the time of the first
        timed.draw(packet)
    assert 0.0 < timed.gpu_s < 4.2
    assert timed.waited_s >= 0.0
    assert timed.timer.wait() > 0.0
    assert timed.timer.wait() == 0.0  # nothing was drawn since


def test_a_time_beyond_the_counter_of_drivers_is_unknown(context):
    timer = GpuTimer(context)
    with timer.picture():
        context.clear()
    timer._whole = SimpleNamespace(elapsed=2**32 - 1)
    assert timer.wait() == 0.0
