"""The settings file: its place, contents and faults."""

import os
import re
from pathlib import Path
from types import SimpleNamespace

import msgspec
import pytest

from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.dive import arguments as cli
from subsea.dive import settings
from subsea.dive.settings import (
    ACTIONS,
    COMMANDS,
    DEFAULTS,
    KIOSK_COMMANDS,
    KioskSettings,
    Settings,
    default_text,
    kiosk_settings,
    read_settings,
    usual_settings,
)
from subsea.rendering.output.quality import CHOICES


@pytest.fixture
def home(tmp_path, monkeypatch):
    """The path of the settings, in its own home folder."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    return settings.settings_path()


def written(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def test_the_default_file_is_complete_and_changes_nothing(tmp_path):
    text = default_text()
    path = written(tmp_path / "settings.toml", text)
    assert read_settings(path) == Settings()
    # With every line uncommented the settings are the same.
    path.write_text(re.sub(r'(?m)^# (?=("[^"]+"|\w+) = )', "", text))
    full = read_settings(path)
    assert set(full.controls) == {*ACTIONS, *COMMANDS}
    assert full.bindings == Settings().bindings
    assert msgspec.structs.replace(full, controls={}) == Settings()
    for table in msgspec.structs.fields(Settings):
        assert f"[{table.name}]" in text
        for field in getattr(table.type, "__struct_fields__", ()):
            assert f"\n# {field} = " in text


def test_limits_and_choices_are_those_of_the_command_line():
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert({"size": [cli.MIN_SIZE - 1, cli.MIN_SIZE]}, settings.DisplaySettings)
    msgspec.convert({"size": [cli.MIN_SIZE, cli.MAX_SIZE]}, settings.DisplaySettings)
    for choice in CHOICES:
        msgspec.convert({"quality": choice}, settings.DisplaySettings)
    assert settings.DisplaySettings().size == cli.SIZE


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("[mouse]\nster = true", "unknown key `ster`, at `mouse`; did you mean 'steer'?"),
        ("[mouse]\nsensitivity = 0", "at `mouse.sensitivity`"),
        ("[display]\nmode = 'domme'", "did you mean 'dome'?, at `display.mode`"),
        ("[display]\nmode = 'hologram'", "; there are: mono, "),  # no similar name
        ("[display]\nquality = 'best'", "at `display.quality`"),
        ("[controls]\nahead = 'W'", "at `controls"),
        ("[controls]\n'full stop' = ['Wheel']", "at `controls`"),
        ("[controls]\nahaed = ['W']", "unknown control 'ahaed'; did you mean 'ahead'?"),
        ("[kiosk]\nleave = ''", "at `kiosk.leave`"),
        ("[", "not valid TOML"),
        ("\0", "not valid TOML"),
    ],
)
def test_faults_are_one_line_with_the_key(tmp_path, text, fault):
    path = written(tmp_path / "mine.toml", text)
    with pytest.raises(UserError) as told:
        read_settings(path)
    assert fault in str(told.value)
    line = 1 if text in "[\0" else 2
    assert str(told.value).startswith(f"{path}:{line}: ")


def test_a_faulty_file_is_renamed_and_reported(home):
    lines = []
    for number in (1, 2):
        written(home, f"nonsense {number}")
        assert usual_settings(lines.append) == Settings()
        assert not home.exists()
        kept = home.with_name(f"settings.toml.kept-{number}")
        assert kept.read_text() == f"nonsense {number}"
        assert len(lines) == number
        assert kept.name in lines[-1]
    assert usual_settings(lines.append) == Settings()
    assert len(lines) == 2


def test_an_unreadable_file_is_reported_and_left(home, monkeypatch):
    lines = []
    home.mkdir(parents=True)  # a folder of that name
    assert usual_settings(lines.append) == Settings()
    home.rmdir()
    written(home, "[mouse]\nsteer = false\n")

    def refuse(self, *args, **named):
        raise PermissionError(13, "Permission denied")

    with monkeypatch.context() as patch:
        for name in ("open", "exists", "read_bytes", "read_text"):
            patch.setattr(Path, name, refuse)
        patch.setattr(os, "open", refuse)
        assert usual_settings(lines.append) == Settings()
    assert [line.split(": ", 1)[1] for line in lines] == [
        "cannot read (it is a folder); the defaults are used",
        "cannot read (Permission denied); the defaults are used",
    ]
    assert [file.name for file in home.parent.iterdir()] == [home.name]
    assert not usual_settings(lines.append).mouse.steer


def test_the_defaults_are_used_if_renaming_fails(home, monkeypatch):
    def refuse(self, other):
        raise PermissionError(13, "Permission denied")

    lines = []
    written(home, "nonsense")
    monkeypatch.setattr(Path, "rename", refuse)
    assert usual_settings(lines.append) == Settings()
    assert "Permission denied" in lines[0]
    assert home.exists()


def test_the_command_prints_the_path_and_writes_the_file_once(home, capsys):
    assert main(["settings"]) == 0
    assert str(home) in capsys.readouterr().out
    assert not home.exists()
    assert main(["settings", "--write"]) == 0
    assert capsys.readouterr().out == f"{home}\n"
    assert home.read_text() == default_text()
    assert main(["settings", "--write"]) == 2
    assert "give --force" in capsys.readouterr().err
    home.write_text("# mine\n")
    assert main(["settings", "--write", "--force"]) == 0
    assert home.read_text() == default_text()


@pytest.fixture
def begun(monkeypatch):
    """A window, and the arguments with which windows and dives are begun."""
    asked, opened, window = [], [], SimpleNamespace(close=lambda: None)
    monkeypatch.setattr("subsea.ui.dive.dive", lambda *given: asked.append(given) or 0)
    monkeypatch.setattr(
        "subsea.ui.open_windows.open_windows",
        lambda *given, **named: opened.append(given) or window,
    )
    return window, opened, asked


def test_the_settings_fill_in_options_that_are_not_given(home, tmp_path, begun):
    window, opened, asked = begun

    def dive(*options):
        assert main(["dive", *options]) == 0
        display = asked[-1][0].display
        return display.mode, display.quality, display.fullscreen, display.size

    written(home, "[display]\nmode = 'dome'\nquality = 'low'\nfullscreen = true\nsize = [300, 200]")
    assert dive() == ("dome", "low", True, (300, 200))
    assert opened == [("dome", (300, 200), True, read_settings(home))]
    assert asked[0][1] is window
    given = dive("--display", "mono", "--no-fullscreen", "--size", "400x300")
    assert given == ("mono", "low", False, (400, 300))
    assert dive("--theatre", "cave")[::2] == ("mono", False)  # its file defines its windows
    other = written(tmp_path / "other.toml", "[display]\nquality = 'high'")
    assert dive("--settings", str(other))[:2] == ("mono", "high")


def test_a_faulty_file_is_reported_on_the_terminal_and_in_the_window(home, begun, capsys):
    written(home, "[mouse]\nster = true")
    assert main(["dive"]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"subsea: {home}:2: unknown key `ster`, at `mouse`")
    ((_, _, (note,)),) = begun[2]
    assert note.startswith("settings.toml:2: unknown key")
    assert note.endswith("kept as settings.toml.kept-1, and the defaults are used")


def test_a_kiosk_has_only_inputs_for_visitors():
    found = kiosk_settings(DEFAULTS).bindings
    assert found.key(ord("Q"), 2 | 1) == "leave"
    assert found.key(ord("Q"), 0) == "dive"
    for wish in COMMANDS:
        assert bool(found.inputs(wish)) == (wish in KIOSK_COMMANDS)
    assert kiosk_settings(with_key("F12")).bindings.control("F12") == "leave"  # no visitor input


@pytest.mark.parametrize(
    ("key", "controls", "rival"), [("F9", {"ride": ["F9"]}, "ride"), ("w", {}, "ahead")]
)
def test_the_operators_key_must_not_be_an_input_of_visitors(key, controls, rival):
    name = key.upper()
    with pytest.raises(UserError, match=f"--kiosk: '{name}' .* '{rival}', at `kiosk.leave`"):
        kiosk_settings(with_key(key, **controls))


def with_key(key, **controls):
    return msgspec.structs.replace(DEFAULTS, controls=controls, kiosk=KioskSettings(leave=key))
