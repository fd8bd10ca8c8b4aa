"""Pages of the menu for what a visitor likes: keys, comfort, sound and language.

A line of the menu.
"""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

from subsea.base.language import LANGUAGES, language, marked, translated
from subsea.dive.settings import COMFORTS, CONTROLS, ControlName, is_key
from subsea.ui.context import DiveContext

ROW = 1.75  # height of an entry, in heights of letters
ABOUT = 0.65  # height of the line below an entry


class Entry(NamedTuple):
    """A line of the menu, in the language of visitors."""

    text: str
    act: Callable[[], object]
    aside: str = ""  # text at its right end
    chosen: bool = False
    about: str = ""  # a line below it
    scenario: Path | None = None  # the file whose picture is at its left end

    @property
    def high(self) -> float:
        """Its height, in heights of letters."""
        return ROW + ABOUT if self.about else ROW


SETTINGS = marked("Settings")
KEYS, MORE = "Keys", 6.0  # a page whose lines are longer, in heights of letters
PARTS = marked("Keys"), marked("Comfort"), marked("Sound"), marked("Language")
KIOSK_PARTS = "Comfort", "Language"
UNREVIEWED = marked("A draft that no native speaker has reviewed.")
PRESETS = {
    "calm": (marked("Calm"), marked("Turns in steps, slow starts, a dark rim while moving.")),
    "usual": (marked("Usual"), marked("Smooth turns, a dark rim while moving fast.")),
    "free": (marked("Free"), marked("Smooth turns, no rim.")),
}
FLAT_PRESETS = {
    "calm": marked("Slow starts, a dark rim in turns."),
    "usual": marked("A line shows the horizon while it tilts."),
    "free": marked("No line, no rim."),
}
VOLUMES = (1.0, 0.8, 0.6, 0.4, 0.2)
GROUPS = {
    "sea": marked("Reef and waves"), "fishes": marked("Fishes"), "vessel": marked("Vessel"),
}  # fmt: skip
GROUP_LEVELS = (1.0, 0.5, 0.0)  # by turns


class SettingsPages:
    """The entries of these pages."""

    def __init__(self, dive: DiveContext, show: Callable[[str], None], kiosk: bool) -> None:
        """`show` opens a page of the menu. In a `kiosk` visitors choose comfort and language."""
        self._dive, self._preferences, self._show = dive, dive.preferences, show
        self._parts = KIOSK_PARTS if kiosk else PARTS
        self._waiting: ControlName | None = None  # for its key
        self.pages: dict[str, Callable[[], Iterator[Entry]]] = {
            SETTINGS: self._settings,
            "Keys": self._keys,
            "Comfort": self._comforts,
            "Sound": self._sounds,
            "Language": self._languages,
        }

    def _settings(self) -> Iterator[Entry]:
        now = {"Sound": self._dive.sound.volume_text, "Language": LANGUAGES[language()]}
        for part in self._parts:
            yield Entry(translated(part), partial(self._show, part), now.get(part, ""))
        yield self._back("")

    def _keys(self) -> Iterator[Entry]:
        bindings = self._preferences.settings.bindings
        for name, control in CONTROLS.items():
            inputs = ", ".join(filter(is_key, bindings.inputs(name)))
            if name == self._waiting:
                inputs = translated("press a key, or Esc")
            yield Entry(translated(control.what), partial(self._ask_key, name), inputs)
        yield Entry(translated("All keys as they were"), self._preferences.usual_keys)
        yield self._back(SETTINGS)

    def _ask_key(self, control: ControlName) -> None:
        self._waiting = control
        self._dive.gui.take_key = partial(self._bind, control)

    def _bind(self, control: ControlName, key: str) -> None:
        self._waiting = None
        if key not in ("", "Esc"):
            self._preferences.bind(control, key)

    def _comforts(self) -> Iterator[Entry]:
        now, worn = self._preferences.settings.comfort, self._dive.picture.head is not None
        for name, comfort in COMFORTS.items():
            title, about = PRESETS[name]
            choose = partial(self._preferences.set_comfort, comfort)
            about = translated(about if worn else FLAT_PRESETS[name])
            yield Entry(translated(title), choose, chosen=now == comfort, about=about)
        yield self._back(SETTINGS)

    def _sounds(self) -> Iterator[Entry]:
        own, change = self._dive.sound.settings, self._change_sound
        for volume in VOLUMES:
            now = not own.mute and own.volume == volume
            yield Entry(f"{volume:.0%}", partial(change, volume=volume, mute=False), chosen=now)
        yield Entry(translated("Off"), partial(change, mute=True), chosen=own.mute)
        for group, title in GROUPS.items():
            level = getattr(own, group)
            lower = next((step for step in GROUP_LEVELS if step < level), GROUP_LEVELS[0])
            yield Entry(translated(title), partial(change, **{group: lower}), f"{level:.0%}")
        for name, on, title, about in (
            ("night", own.night, marked("Night"), marked("Loud sounds are softer.")),
            ("captions", own.captions, marked("Captions"), marked("Sounds are shown in words.")),
        ):
            state = translated(marked("on") if on else marked("off"))
            flip = partial(change, **{name: not on})
            yield Entry(translated(title), flip, state, about=translated(about))
        yield self._back(SETTINGS)

    def _change_sound(self, **values: object) -> None:
        self._dive.sound.change(**values)
        self._preferences.keep_sound(**values)

    def _languages(self) -> Iterator[Entry]:
        for code, name in LANGUAGES.items():
            choose = partial(self._preferences.set_language, code)
            about = "" if code == "en" else translated(UNREVIEWED)
            yield Entry(name, choose, chosen=code == language(), about=about)
        yield self._back(SETTINGS)

    def _back(self, page: str) -> Entry:
        return Entry(translated("Back"), partial(self._show, page))
