"""The time without input after which a tour begins."""

from subsea.dive.idle_timer import DIP_S, IdleTimer


def test_a_tour_begins_after_idle_time_and_ends_with_input():
    timer = IdleTimer(10.0, leaps=False)
    done = [timer.update(False, 1.0) for _ in range(12)]
    assert done.count("begin") == 1 and done[9] == "begin"
    assert timer.update(True, 1.0) == "end" and not timer.touring
    assert timer.update(True, 100.0) is None
    assert [timer.update(False, 9.0), timer.update(False, 0.9)] == [None, None]
    assert timer.update(False, 100.0, allowed=False) is None
    assert timer.update(False, 0.1) == "begin"
    never = IdleTimer(0.0, leaps=False)
    assert never.update(False, 1e6) is None


def test_the_picture_darkens_before_a_tour_that_begins_elsewhere():
    timer = IdleTimer(10.0, leaps=True)
    assert timer.update(False, 10.0 - DIP_S / 2.0) is None and timer.shade == 0.0
    assert timer.update(False, DIP_S / 2.0) is None and timer.shade == 0.5
    assert timer.update(True, DIP_S / 4.0) is None and timer.shade == 0.25
    assert timer.update(False, 10.0) == "begin" and timer.shade == 1.0
    assert timer.update(False, DIP_S) is None and timer.shade == 0.0
