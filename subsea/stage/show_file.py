"""Read a show: a file of items, one after the other, by the clock or on cue."""

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import msgspec

from subsea.base.errors import UserError
from subsea.base.input_files import file_hash
from subsea.base.resources import is_path
from subsea.base.toml_files import error_at, load_toml
from subsea.dive.directed_camera import check_tour
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import AUTOPILOT, DIRECTED, Scenario
from subsea.stage.opening_hours import OpeningHours, minutes_of

AFTER, CUE = "after", "cue"
MOST_ITEMS = 200

Seconds = Annotated[float, msgspec.Meta(ge=1, le=86400)]
Fade = Annotated[float, msgspec.Meta(ge=0, le=30)]
Words = Annotated[str, msgspec.Meta(max_length=300)]


class ShowItem(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A part of a show."""

    scenario: Annotated[str, msgspec.Meta(min_length=1, max_length=500)] | None = None
    tour: Annotated[str, msgspec.Meta(min_length=1, max_length=100)] | None = None
    start: str = AFTER  # or CUE, or a time of the day
    for_s: Seconds | None = None
    caption: Words = ""
    caption_s: Seconds | None = None
    fade_s: Fade | None = None  # into black, and out of it again; None: that of the show

    def __post_init__(self) -> None:
        """Refuse an invalid start."""
        if self.start not in (AFTER, CUE):
            try:
                minutes_of(self.start)
            except ValueError:
                raise ValueError(
                    f"`start` is {self.start!r}, expected 'after', 'cue' or a time such as '10:30'"
                ) from None

    @property
    def minute(self) -> int | None:
        """Minutes after midnight at which it starts; None: not by the clock."""
        return None if self.start in (AFTER, CUE) else minutes_of(self.start) % (24 * 60)


class Show(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A whole show."""

    title: Words = ""
    repeat: bool = True  # the first item follows the last
    fade_s: Fade = 1.0
    hours: OpeningHours | None = None
    item: Annotated[list[ShowItem], msgspec.Meta(min_length=1, max_length=MOST_ITEMS)]


def load_show(path: Path) -> Show:
    """Read a show; a UserError names line and key. Its scenarios are not read: see `faults`."""
    show = load_toml(path, Show)
    if show.item[0].scenario is None:
        raise error_at(path, "item[0]", "`item[0]`: the first item needs a `scenario`")
    for k, (one, after) in enumerate(zip(show.item, show.item[1:], strict=False)):
        if one.for_s is None and after.start == AFTER:
            message = (
                f"`item[{k}]`: expected `for_s`, as item {k + 2} starts after it; or a `start` of "
                "item {}".format(k + 2)
            )
            raise error_at(path, f"item[{k}]", message)
    starts = [one.minute for one in show.item]
    for k, minute in enumerate(starts):
        if minute is not None and minute in starts[:k]:
            raise error_at(path, f"item[{k}].start", f"two items start at {show.item[k].start}")
    return show


def show_digest(path: Path) -> str:
    """A digest of a show's file."""
    return hashlib.sha256(file_hash(path).encode()).hexdigest()[:16]


def scenario_name(show: Show, path: Path, number: int) -> str:
    """The scenario of an item: its own, or that of the nearest one before it.

    A path is relative to the file of the show.
    """
    name = next(one.scenario for one in reversed(show.item[: number + 1]) if one.scenario)
    return str(path.parent / name) if is_path(name, ".toml") else name


def open_item(show: Show, path: Path, number: int) -> tuple[Scenario, Path]:
    """The scenario of an item and its file; a UserError if that or the tour is missing."""
    scenario, file = load_scenario(scenario_name(show, path, number))
    if (tour := show.item[number].tour) is not None:
        check_tour(scenario, tour)
    return scenario, file


def check_for_cluster(show: Show, path: Path) -> None:
    """Refuse what several computers cannot play together, with line and key.

    Nodes open scenarios by name, and a submarine that is under way cannot be put elsewhere.
    """
    for k, one in enumerate(show.item):
        if one.scenario is not None and is_path(one.scenario, ".toml"):
            message = (
                f"{one.scenario!r} is a path, expected a name that all computers of a cluster know"
            )
            raise error_at(path, f"item[{k}].scenario", f"`item[{k}].scenario`: {message}")
        if one.tour not in (None, AUTOPILOT, DIRECTED):
            message = f"{one.tour!r} begins elsewhere; in a cluster expected "
            message += f"{AUTOPILOT!r} or {DIRECTED!r}"
            raise error_at(path, f"item[{k}].tour", f"`item[{k}].tour`: {message}")


def faults(show: Show, path: Path) -> Iterator[tuple[int, UserError]]:
    """Items whose scenario or tour is missing or faulty."""
    for number in range(len(show.item)):
        try:
            open_item(show, path, number)
        except UserError as fault:
            key = f"item[{number}]"
            key += ".tour" if str(fault).startswith(("unknown tour", "tour ")) else ".scenario"
            yield number, error_at(path, key, f"item {number + 1}: {fault}")
