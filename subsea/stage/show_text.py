"""Describe a show: `subsea show`."""

from datetime import date
from pathlib import Path

from subsea.base.console import count_noun, say
from subsea.stage.opening_hours import hours_text
from subsea.stage.show import timetable
from subsea.stage.show_file import ShowItem, faults, load_show
from subsea.stage.show_state import DiveCount


def describe_show(path: Path) -> int:
    """Print the timetable of today and what is missing; 1 if anything is."""
    show, today = load_show(path), date.today()
    items = count_noun(len(show.item), "item", "items")
    print(f"{show.title or path.name}: {items}, {hours_text(show.hours, today)} today")
    for start, number in timetable(show):
        print(f"{number + 1:>4}  {start:<14}{_described(show.item[number])}")
    if show.repeat:
        print("      then from the beginning")
    print(f"dives of visitors today: {DiveCount(say).of(today)}")
    missing = list(faults(show, path))
    for _, fault in missing:
        say(str(fault))
    return 1 if missing else 0


def _described(one: ShowItem) -> str:
    parts = [one.scenario or "the same sea"]
    parts += [f"tour {one.tour}" if one.tour else "steered"]
    parts += [] if one.for_s is None else [f"{one.for_s:g} s"]
    parts += [f"\N{LEFT DOUBLE QUOTATION MARK}{one.caption}\N{RIGHT DOUBLE QUOTATION MARK}"] * bool(
        one.caption
    )
    return ", ".join(parts)
