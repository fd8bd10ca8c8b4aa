"""Learning and recording as processes: progress, results and stopping."""

import time
from types import SimpleNamespace

import pytest

from subsea.cli.main import parsers
from subsea.fish.species import species_file
from subsea.scenario.load import load_scenario
from subsea.scenario.shoals import find_fish
from subsea.studio.builder.jobs import CaptureJobs, CommandProcess, _describe_end

PATIENCE_S = 60.0


@pytest.fixture
def jobs():
    jobs = CaptureJobs(lambda: None)
    yield jobs
    jobs.close()


def end_of(jobs):
    """The finished job and its result."""
    end = time.monotonic() + PATIENCE_S
    while (found := jobs.ended()) is None and time.monotonic() < end:
        time.sleep(0.05)
    assert found, jobs.doing
    return found


def test_a_failed_recording_is_reported_in_a_sentence(jobs):
    jobs.record("no_such_fish")
    assert jobs.running and jobs.doing == "recording…"
    assert end_of(jobs) == ("record", 2)
    assert jobs.message.startswith("That failed: ") and "no_such_fish" in jobs.message
    assert not jobs.running and jobs.ended() is None


@pytest.mark.nightly
def test_learning_that_is_stopped_leaves_the_file_as_it_was(jobs, tmp_path):
    path = tmp_path / "fish.toml"
    path.write_bytes(species_file("fusilier").read_bytes())
    jobs.tries = 200  # so that soon one percent is done, but not all
    jobs.learn(path)
    end = time.monotonic() + PATIENCE_S
    while jobs.progress == 0.0 and jobs.running and time.monotonic() < end:
        time.sleep(0.05)
    assert 0.0 < jobs.progress < 0.5 and "swim" in jobs.doing and "best" in jobs.doing
    jobs.stop()
    assert end_of(jobs)[0] == "learn"
    assert jobs.message == "Stopped; the file is as it was."
    assert path.read_bytes() == species_file("fusilier").read_bytes()


def test_a_dive_follows_the_fish(jobs, monkeypatch):
    """Another species of the scenario comes first."""
    commands = []
    monkeypatch.setattr(
        "subsea.studio.builder.jobs.subprocess.Popen",
        lambda command, **how: commands.append(command),
    )
    monkeypatch.setattr(CaptureJobs, "close", lambda self: None)
    jobs.dive("clownfish")
    options = parsers()[0].parse_args(commands[0][commands[0].index("subsea") + 1 :])
    scenario = load_scenario(options.scenario, options.changes).scenario
    number = find_fish(options.follow, scenario)
    shoals = [one.species for one in scenario.fish for _ in range(one.number)]
    assert shoals[number] == "clownfish"


def test_a_warning_of_recording_is_passed_on():
    warned = SimpleNamespace(stopped=False, last="warning: The medium swim turns by -9.6° a beat.")
    message = _describe_end("record", "red_fish", warned, 0)
    assert message == "red_fish is recorded, with a warning. The medium swim turns by -9.6° a beat."


def test_the_ends_of_a_fit_are_told_in_sentences():
    ended = SimpleNamespace(stopped=False, last="")
    assert "fit the outline now" in _describe_end("fit", "red_fish", ended, 0)
    assert "as it was" in _describe_end("fit", "red_fish", ended, 1)
    ended.stopped = True
    assert "goes on where it stopped" in _describe_end("fit", "red_fish", ended, 130)


def test_lines_and_progress_bars_are_distinguished():
    process = CommandProcess(["capture", "--help"])
    process.close()
    process.parse("red_fish: swim:  43%|####      | 129/300 [00:10<00:13, best 0.2150]")
    assert process.progress == 0.43 and process.doing == "red_fish: swim · best 0.2150"
    process.parse("repertoires/red_fish.h5")
    assert process.last == "repertoires/red_fish.h5" and process.progress == 0.43
