"""Where there is no terminal, a line now and then tells how far a work is."""

from subsea.base import progress as module
from subsea.base.progress import clock, progress


def test_without_a_terminal_there_is_a_line_every_ten_seconds(capsys, monkeypatch):
    now = 0.0
    monkeypatch.setattr(module.time, "monotonic", lambda: now)
    with progress(100, "frame", done=20) as count:
        for _ in range(60):
            now += 0.5
            count()
    lines = capsys.readouterr().err.splitlines()
    assert lines == [
        "subsea: frame 40 of 100, 2 a second, 0:30 left",
        "subsea: frame 60 of 100, 2 a second, 0:20 left",
        "subsea: frame 80 of 100, 2 a second, 0:10 left",
    ]


def test_short_work_prints_nothing(capsys):
    with progress(3, "frame") as count:
        for _ in range(3):
            count()
    assert not capsys.readouterr().err


def test_durations_are_formatted_as_clocks():
    assert [clock(s) for s in (0.2, 59.6, 3723.0)] == ["0:00", "1:00", "1:02:03"]
