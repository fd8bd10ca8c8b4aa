"""Damaged files are read or refused in one line, and the tool finds violations."""

import os
import subprocess
import sys
import time

import pytest

from tools import fuzz


@pytest.mark.nightly
def test_damaged_files_are_read_or_refused_in_one_line(tmp_path, pytestconfig):
    rounds = 400 if pytestconfig.getoption("--nightly") else 2
    done = subprocess.run(
        [sys.executable, fuzz.__file__, "--rounds", str(rounds), "--keep", tmp_path / "kept"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count(f"{rounds} damaged files, 0 findings") == 33
    assert not (tmp_path / "kept").exists()


def test_samples_are_sound(tmp_path):
    for name in fuzz.KINDS.keys() - {"record", "snapshot"}:  # these are made by what they are of
        kind = fuzz.KINDS[name]
        for sample in kind.samples(tmp_path)[:2]:
            (tmp_path / f"sound{kind.suffix}").write_bytes(sample)
            kind.read(tmp_path / f"sound{kind.suffix}")


def refuses_without_words(path):
    from subsea.base.errors import UserError

    raise UserError("")


def never_comes_back(path):
    import signal

    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGALRM])  # as a library does that loops
    time.sleep(1000)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("read", "found"),
    [
        (lambda path: None, None),
        (lambda path: os._exit(7), "the process ended with 7"),
        (lambda path: 1 // 0, "ZeroDivisionError"),
        (lambda path: time.sleep(1000), "TimeoutError"),
        (never_comes_back, "the process ended with -9"),
        (lambda path: bytearray(3 * 2**30), "MemoryError"),
        (lambda path: path.with_name("other").write_text("x"), "written: "),
        (refuses_without_words, "not one line"),
    ],
    ids=["sound", "crash", "fault", "slow", "hang", "memory", "writing", "no words"],
)
def test_each_kind_of_reader_fault_is_found(monkeypatch, tmp_path, capsys, read, found):
    monkeypatch.setattr(fuzz, "SECONDS", 0.5)
    monkeypatch.setattr(fuzz, "KILL_AFTER", 2)
    kind = fuzz.Kind(".toml", lambda folder: [b"a = 3"], read)
    number = fuzz.fuzz("any", kind, 2 if found is None else 1, 0, tmp_path / "kept")
    assert number == (0 if found is None else 1)
    told = capsys.readouterr().out
    assert (found or "0 findings") in told
    assert (tmp_path / "kept" / "any-0-0.toml").exists() == (found is not None)


def test_every_accident_happens():
    import random

    sample = b"[a]\nx = 3\ny = [1.5, 2]\n"
    made = {fuzz.damage(sample, ".toml", random.Random(k)) for k in range(300)}
    assert len(made) > 200
    for sign in (b"nan", b"\xff\xfe", b"[[[[[", b"\0" * 8, b"x = 3\nx = 3"):
        assert any(sign in one for one in made), sign
