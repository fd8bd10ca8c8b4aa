"""The board between the threads of dive and server."""

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.stage.console.board import MOST_WAITING, WANTED_S, Board
from subsea.stage.console.commands import LeaveFish, StopTour


def test_commands_are_taken_in_turn_and_results_returned():
    board = Board()
    first, second = board.put(StopTour()), board.put(LeaveFish())
    command, done = board.take()
    assert command == StopTour()
    done.set_result("stopped")
    assert first.result(0) == "stopped" and not second.done()
    assert board.take()[0] == LeaveFish() and board.take() is None


def test_the_queue_is_bounded_and_withdrawn_commands_are_skipped():
    board = Board()
    waiting = [board.put(StopTour()) for _ in range(MOST_WAITING)]
    with pytest.raises(UserError, match="busy"):
        board.put(StopTour())
    assert all(one.cancel() for one in waiting)
    assert board.take() is None
    board.put(LeaveFish())
    assert board.take()[0] == LeaveFish()


def test_pictures_are_wanted_for_a_while_after_a_request():
    now = [0.0]
    board = Board(lambda: now[0])
    assert not board.picture_wanted and not board.alive
    board.want_picture()
    board.beat()
    assert board.picture_wanted and board.alive
    now[0] = WANTED_S + 0.1
    assert not board.picture_wanted and board.alive and board.beat_age_s == now[0]
    now[0] = 10.0
    assert not board.alive
    board.show(np.zeros((2, 3, 4), np.uint8))
    assert board.picture_number == 1
