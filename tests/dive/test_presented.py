"""Overlays of a presenter fade by the wall clock."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.dive.captions import shown_s
from subsea.dive.presented import BLANK_S, NOTHING, Presentation, Presented


def test_black_comes_and_goes_in_half_a_second():
    presentation = Presentation()
    assert presentation.update(1.0) == NOTHING
    presentation.blank = True
    assert presentation.update(0.5 * BLANK_S).blank == pytest.approx(0.5)
    assert presentation.update(BLANK_S).blank == 1.0
    presentation.blank = False
    assert presentation.update(0.25 * BLANK_S).blank == pytest.approx(0.75)
    assert presentation.update(BLANK_S).blank == 0.0


def test_a_caption_stays_as_long_as_it_takes_to_read():
    presentation = Presentation()
    presentation.show_caption("Good evening")
    shown = [presentation.update(0.1) for _ in range(100)]
    there = sum(one.caption == "Good evening" for one in shown)
    assert 0.1 * there == pytest.approx(shown_s("Good evening", None), abs=0.2)
    assert max(one.opacity for one in shown) == 1.0 and shown[0].opacity < 0.2
    presentation.show_caption("again", 2.0)
    assert presentation.update(0.1).caption == "again"
    presentation.show_caption("")
    assert presentation.update(0.1) == NOTHING


@given(st.lists(st.tuples(st.floats(0.0, 5.0), st.booleans(), st.text(max_size=300)), max_size=20))
def test_it_always_fits_into_a_message(steps):
    presentation = Presentation()
    for elapsed_s, blank, words in steps:
        presentation.blank = blank
        presentation.show_caption(words)
        shown = presentation.update(elapsed_s)
        assert msgspec.msgpack.decode(msgspec.msgpack.encode(shown), type=Presented) == shown
