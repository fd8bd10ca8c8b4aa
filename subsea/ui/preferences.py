"""Settings that a visitor changes in a dive: they act at once, and are kept for the next one."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
from msgspec.structs import replace

from subsea.base.errors import UserError
from subsea.base.files import read_text, replacing
from subsea.base.language import next_language, set_language
from subsea.base.toml_edit import edit_toml
from subsea.dive.settings import ComfortSettings, ControlName, Settings, is_key


class Preferences:
    """The current settings, and those that were changed."""

    def __init__(
        self, settings: Settings, file: Path | None, apply: Callable[[Settings], object]
    ) -> None:
        """`apply` makes the dive follow settings, but for sound. Changes go to `file`, if any."""
        self.settings = settings
        self._start, self._file, self._apply = settings, file, apply
        self._changes: dict[str, dict[str, Any]] = {}  # by table and key; None: as it is without

    def bind(self, control: ControlName, key: str) -> None:
        """Bind a key to a control, in place of its other keys and from any other control."""
        bindings = self.settings.bindings
        kept = [name for name in bindings.inputs(control) if not is_key(name)]
        controls: dict[str, list[str]] = {control: [key, *kept]}
        for other in bindings.controls.get(key, ()):
            if other not in (control, "alight"):
                controls[other] = [name for name in bindings.inputs(other) if name != key]
        self._change("controls", self.settings.controls | controls, controls)

    def usual_keys(self) -> None:
        """Give all keys, buttons and parts of a gamepad their usual controls."""
        self._change("controls", {}, dict.fromkeys(self.settings.controls))

    def set_comfort(self, comfort: ComfortSettings) -> None:
        """Choose how gently the submarine moves."""
        self._change("comfort", comfort, msgspec.to_builtins(comfort))

    def keep_sound(self, **values: object) -> None:
        """Keep settings of the sound for the next dive; the sound itself has changed."""
        self._change("sound", replace(self.settings.sound, **values), values)

    def set_display(self, **values: object) -> None:
        """Change settings of the display."""
        self._change("display", replace(self.settings.display, **values), values)

    def set_touch(self, on: bool) -> None:
        """Choose whether a touch screen steers."""
        self._change("mouse", replace(self.settings.mouse, touch=on), {"touch": on})

    def set_language(self, code: str) -> None:
        """Choose a language by its code."""
        self.set_display(language=code)

    def next_language(self) -> None:
        """Choose the next language, cyclically."""
        self.set_language(next_language())

    def restore(self) -> None:
        """Return to the settings of the start, for the next visitor."""
        if self.settings is not self._start:
            self.settings, self._changes = self._start, {}
            self._follow()

    def keep(self, note: Callable[[str], object]) -> None:
        """Save, and note a fault."""
        try:
            self.save()
        except UserError as fault:
            note(str(fault))

    def save(self) -> None:
        """Write what was changed into the file, and leave the rest of it; UserError if it fails."""
        changes, self._changes = self._changes, {}
        if self._file is None or not changes:
            return
        try:
            text = read_text(self._file) if self._file.exists() else ""
            old = tomllib.loads(text)
            self._file.parent.mkdir(parents=True, exist_ok=True)
            with replacing(self._file) as part:
                part.write_bytes(edit_toml(text, old, _merged(old, changes)).encode("utf-8"))
        except (OSError, ValueError) as fault:
            raise UserError(f"the settings were not kept ({fault})", file=self._file) from fault

    def _change(self, table: str, whole: Any, values: dict[str, Any]) -> None:
        self.settings = replace(self.settings, **{table: whole})
        self._changes.setdefault(table, {}).update(values)
        self._follow()

    def _follow(self) -> None:
        set_language(self.settings.display.language)
        self._apply(self.settings)


def _merged(old: dict[str, Any], changes: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """The content of a settings file with the changes; a value of None is left out."""
    new = dict(old)
    for table, values in changes.items():
        both = old.get(table, {}) | values
        new[table] = {key: value for key, value in both.items() if value is not None}
    return new
