"""Where `subsea-capture record` writes is settled before it swims a fish."""

from pathlib import Path

import pytest

from capture.cli import main as cli
from capture.cli import record as command
from capture.recording import record


@pytest.fixture(autouse=True)
def no_swimming(monkeypatch: pytest.MonkeyPatch) -> None:
    def swim(*arguments: object) -> None:
        pytest.fail("swam before the fault was told")

    monkeypatch.setattr(record, "make_segment", swim)


def one_line(capsys: pytest.CaptureFixture[str]) -> str:
    out, err = capsys.readouterr()
    assert not out
    assert err.count("\n") == 1
    return err


@pytest.mark.parametrize("folder", ["/etc/passwd", "/etc/passwd/new", "/proc"])
def test_a_folder_that_cannot_be_written_to(
    folder: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["record", "fusilier", "--out", folder]) == 2
    assert folder in one_line(capsys)


def test_all_with_a_name_is_an_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["record", "fusilier", "--all"]) == 2
    assert "'fusilier'" in one_line(capsys)


def test_an_installed_package_is_not_written_into(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command, "resource_path", lambda name: tmp_path / name)
    assert cli.main(["record", "fusilier"]) == 2
    assert "--out" in one_line(capsys)
    assert not list(tmp_path.iterdir())
