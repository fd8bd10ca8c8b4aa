"""Learning and recording as processes: their progress, their ends, and that they can be stopped."""

import time

import pytest

from subsea.fish.species import species_file
from subsea.ui.fish_builder.jobs import Making
from subsea.ui.fish_builder.processes import Run

PATIENCE_S = 60.0


@pytest.fixture
def making():
    making = Making(lambda: None)
    yield making
    making.close()


def end_of(making):
    """What ended, and how."""
    end = time.monotonic() + PATIENCE_S
    while (found := making.ended()) is None and time.monotonic() < end:
        time.sleep(0.05)
    assert found, making.doing
    return found


def test_what_cannot_be_recorded_is_told_in_a_sentence(making):
    making.record("no_such_fish")
    assert making.runs and making.doing == "recording…"
    assert end_of(making) == ("record", 2)
    assert making.told.startswith("That failed: ") and "no_such_fish" in making.told
    assert not making.runs and making.ended() is None


def test_learning_that_is_stopped_leaves_the_file_as_it_was(making, tmp_path):
    path = tmp_path / "fish.toml"
    path.write_bytes(species_file("fusilier").read_bytes())
    making.tries = 3000
    making.learn(path)
    end = time.monotonic() + PATIENCE_S
    while making.share == 0.0 and making.runs and time.monotonic() < end:
        time.sleep(0.05)
    assert 0.0 < making.share < 0.5 and "swim" in making.doing and "best" in making.doing
    making.stop()
    assert end_of(making)[0] == "learn"
    assert making.told == "Stopped; the file is as it was."
    assert path.read_bytes() == species_file("fusilier").read_bytes()


def test_lines_and_bars_are_told_apart():
    run = Run(["capture", "--help"])
    run.close()
    run._heard("red_fish: swim:  43%|####      | 129/300 [00:10<00:13, best 0.2150]")
    assert run.share == 0.43 and run.doing == "red_fish: swim · best 0.2150"
    run._heard("repertoires/red_fish.h5")
    assert run.last == "repertoires/red_fish.h5" and run.share == 0.43
