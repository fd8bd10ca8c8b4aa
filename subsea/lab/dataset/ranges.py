"""Values that differ between the pictures of a set: their ranges, and what is drawn from them."""

import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from subsea.base.errors import UserError, unknown
from subsea.base.files import read_text
from subsea.base.toml_edit import toml_value
from subsea.lab.sweep import split_values

# Keys that are drawn for each picture, with the bounds of their values. Any other key is the
# scenario's, and drawn for each scene.
PICTURE_KEYS: dict[str, tuple[float, float]] = {
    "camera.field_deg": (10.0, 140.0),  # angle from left to right
    "camera.distance": (0.5, 100.0),  # of a random camera from a fish, body lengths
    "camera.aside": (0.0, 1.0),  # of the fish from the middle, as a share of half the field
    "camera.k1": (-1.0, 1.0),  # radial distortion
    "camera.k2": (-1.0, 1.0),
    "camera.port_gap_cm": (0.0, 50.0),  # air between the lens and a flat port; below 0 none
    "camera.lamps": (0.0, 1.0),  # true: lamps beside the camera
    "sensor.noise": (0.0, 100.0),  # standard deviation of a middle grey, of 255
    "sensor.blur_px": (0.0, 50.0),  # standard deviation of the blur
    "jpeg.quality": (1.0, 100.0),  # 1 to 100
}
WHOLE = ("jpeg.quality",)
DEFAULTS: dict[str, Any] = {
    "camera.field_deg": 70.0, "camera.distance": (2.0, 9.0), "camera.aside": (0.0, 0.7),
    "camera.k1": 0.0, "camera.k2": 0.0, "camera.lamps": False, "sensor.noise": 0.0,
    "sensor.blur_px": 0.0, "jpeg.quality": 92,
}  # fmt: skip
OWN = ("camera", "sensor", "jpeg")  # tables of PICTURE_KEYS, which no scenario has


class DrawnRange(NamedTuple):
    """The values of a key: between two numbers, or a list of choices."""

    key: str
    low: float = 0.0
    high: float = 0.0
    whole: bool = False  # whole numbers only
    choices: tuple[Any, ...] = ()

    def at(self, share: float) -> Any:
        """Return the value at a share in [0, 1) of the range."""
        if self.choices:
            return self.choices[int(share * len(self.choices))]
        if self.whole:
            return int(self.low + int(share * (self.high - self.low + 1)))
        return self.low + share * (self.high - self.low)

    @property
    def ends(self) -> tuple[Any, ...]:
        """All choices, or both ends."""
        return self.choices or (self.at(0.0), int(self.high) if self.whole else self.high)


def read_ranges(settings: Sequence[str], path: Path | None = None) -> dict[str, DrawnRange]:
    """Read the ranges of ``--vary KEY=LOW:HIGH`` or ``KEY=A,B,C``, and those of a file before them.

    A file has a line ``"KEY" = "LOW:HIGH"`` or ``"KEY" = [A, B, C]`` for each key. Raises a
    UserError for anything else; keys of the scenario are checked by its loading.
    """
    found = {} if path is None else _read_file(path)
    given: set[str] = set()
    for setting in settings:
        key, equals, text = (part.strip() for part in setting.partition("="))
        where = f"--vary {setting}"
        if not equals or not key or not text:
            raise UserError("expected KEY=LOW:HIGH or KEY=A,B,C", file=where)
        if key in given:
            raise UserError("is given twice; give all values at once", file=f"--vary {key}")
        given.add(key)
        found[key] = _range(key, text, where)
    return found


def _read_file(path: Path) -> dict[str, DrawnRange]:
    try:
        content = tomllib.loads(read_text(path))
    except (tomllib.TOMLDecodeError, RecursionError) as fault:
        raise UserError(f"{fault}".partition("\n")[0], file=path) from fault
    found = {}
    for key, value in _flat(content):
        where = f"{path}: {key}"
        if isinstance(value, list):
            text = ",".join(toml_value(one) for one in value)
        else:
            text = value if isinstance(value, str) else toml_value(value)
        found[key] = _range(key, text, where)
    return found


def _flat(table: Mapping[str, Any], before: str = "") -> list[tuple[str, Any]]:
    pairs: list[tuple[str, Any]] = []
    for key, value in table.items():
        name = f"{before}{key}"
        pairs += _flat(value, f"{name}.") if isinstance(value, dict) else [(name, value)]
    return pairs


def _range(key: str, text: str, where: str) -> DrawnRange:
    if key.partition(".")[0] in OWN and key not in PICTURE_KEYS:
        raise UserError(f"{unknown('key', key, list(PICTURE_KEYS))}", file=where)
    low, colon, high = text.partition(":")
    if colon and '"' not in text and "[" not in text:
        try:
            ends = float(low), float(high)
        except ValueError:
            raise UserError("expected two numbers, such as 0.5:2", file=where) from None
        if not np.isfinite(ends).all() or ends[0] > ends[1]:
            raise UserError("expected LOW:HIGH with LOW below HIGH", file=where)
        found = DrawnRange(key, *ends, whole=key in WHOLE)
    else:
        found = DrawnRange(
            key, choices=tuple(_value(part, key, where) for part in split_values(text))
        )
    if key in PICTURE_KEYS:
        least, most = PICTURE_KEYS[key]
        for value in found.ends:
            number = isinstance(value, int | float)
            if not number or not least <= float(value) <= most:
                raise UserError(f"{value!r}, expected {least:g} to {most:g}", file=where)
    return found


def _value(text: str, key: str, where: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (tomllib.TOMLDecodeError, RecursionError):
        if key in PICTURE_KEYS or not text:
            raise UserError(f"{text!r}, expected a number", file=where) from None
        return text  # --set takes a bare word as a text, too


def drawn(ranges: Mapping[str, DrawnRange], seed: Sequence[int]) -> dict[str, Any]:
    """Draw a value of each range; the same seed gives the same values, also of other sets of keys.

    Each key has random numbers of its own, so a range more does not change the values of others.
    """
    out = {}
    for key, one in ranges.items():
        letters = [*key.encode()]
        out[key] = one.at(float(np.random.default_rng([*seed, *letters]).random()))
    return out


def picture_ranges(ranges: Mapping[str, DrawnRange]) -> dict[str, DrawnRange]:
    """Choose the ranges that are drawn for each picture, with the defaults of others."""
    found = {}
    for key, value in DEFAULTS.items():
        low_high = isinstance(value, tuple)
        found[key] = DrawnRange(key, *value) if low_high else DrawnRange(key, choices=(value,))
    return found | {key: one for key, one in ranges.items() if key in PICTURE_KEYS}


def scene_ranges(ranges: Mapping[str, DrawnRange]) -> dict[str, DrawnRange]:
    """Choose the ranges of the scenario, which are drawn for each scene."""
    return {key: one for key, one in ranges.items() if key not in PICTURE_KEYS}


def fitted(
    ranges: Mapping[str, DrawnRange], accepts: Callable[[str], bool]
) -> dict[str, DrawnRange]:
    """Make ranges whole whose key takes only whole numbers; `accepts` tries a change."""
    found = dict(ranges)
    for key, one in scene_ranges(ranges).items():
        whole = not one.choices and one.low.is_integer() and one.high.is_integer()
        if whole and not accepts(change_of(key, one.low)):
            found[key] = one._replace(whole=accepts(change_of(key, int(one.low))))
    return found


def change_of(key: str, value: Any) -> str:
    """Return a change of the scenario as ``--set`` takes it."""
    return f"{key}={value if isinstance(value, str) else toml_value(value)}"
