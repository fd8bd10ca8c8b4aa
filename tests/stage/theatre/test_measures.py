"""Questions about a new theatre, and their answers."""

import pytest

from subsea.stage.theatre.measures import KINDS, MEASURES, ask, chosen


def answering(*answers):
    """A reader of lines that gives these answers, and the list of questions that it was asked."""
    asked, left = [], list(answers)

    def read(question):
        asked.append(question)
        return left.pop(0) if left else ""

    return read, asked


@pytest.mark.parametrize("kind", KINDS)
def test_empty_answers_are_the_defaults(kind):
    read, asked = answering(kind)
    assert ask({}, read, print) == (kind, chosen(kind, {}))
    assert len(asked) == 1 + sum(kind in one.defaults for one in MEASURES)
    assert all(question.endswith("]: ") for question in asked)


def test_an_answer_that_does_not_fit_is_asked_again_with_the_reason():
    read, asked = answering("ball", "dome", "0", "many", "8")
    told = []
    kind, measures = ask({}, read, told.append)
    assert (kind, measures["projectors"]) == ("dome", 8)
    assert told == [
        "unknown kind of theatre 'ball'; did you mean 'wall'?",
        "'0': expected a whole number from 1 to 32",
        "'many': expected a whole number from 1 to 32",
    ]
    assert asked[2] == asked[3] == asked[4]


def test_an_option_is_not_asked_for():
    read, asked = answering("wall")
    _, measures = ask({"width": 500.0}, read, print)
    assert measures["width"] == 500.0
    assert not any("width of the screen" in question for question in asked)
