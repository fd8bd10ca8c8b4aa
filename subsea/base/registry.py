"""Find what wings and other packages add to this one, by entry points.

A package names in its metadata a group, a name and a place in its code, as for pytest or napari.
The place is imported when it is needed, not when it is found.
"""

from collections.abc import Iterator
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from subsea.base.errors import UserError, printable, unknown
from subsea.base.progress import say

COMMANDS = "subsea.commands"
"""Modules with a command of `subsea`: `add(commands)`, and GROUP, its heading in the help."""
CAPTURE_COMMANDS = "subsea.capture_commands"
"""The same for `subsea-capture`."""
DIVE_PARTS = "subsea.dive_parts"
"""Modules with a part of a dive: see `subsea.dive.part`."""
VIEWS = "subsea.views"
"""Modules that make the rig of a named file: see `subsea.view.display_rigs.chosen_rig`."""
LISTS = "subsea.lists"
"""Functions that return the files of a kind for `subsea list`."""
DEVICES = "subsea.devices"
"""Functions that describe a device for `subsea doctor`."""
SOAKS = "subsea.soaks"
"""Functions that soak something other than the sea for `subsea soak`."""
LIBRARIES = "subsea.libraries"
"""Packages that programs import by a shorter name, such as `subsea.environments`."""
THEATRE_FORMATS = "subsea.theatre_formats"
"""Functions that read a theatre from another program's file, by its suffix without the dot."""
BEHAVIORS = "subsea.behaviors"
"""Behaviors of fishes: see `subsea.behavior.table`."""

MEASURES = "subsea.measures"
"""Functions that measure a record: see `subsea.lab.own_measures`."""


def registered(group: str) -> dict[str, EntryPoint]:
    """The entry points of a group by name, in the order of their names.

    Of two with one name this package's own counts, so that none of ours can be replaced.
    """
    points = sorted(_installed().select(group=group), key=lambda one: (one.name, _is_foreign(one)))
    found: dict[str, EntryPoint] = {}
    for point in points:
        found.setdefault(point.name, point)
    return found


def load(point: EntryPoint) -> Any:
    """Import what an entry point names; a UserError names the package where that fails."""
    try:
        return point.load()
    except (ImportError, AttributeError) as fault:
        if not _is_foreign(point):
            raise
        package = "a package" if point.dist is None else point.dist.name
        reason = printable(str(fault))
        raise UserError(
            f"{package}: cannot load {point.value} of {point.group}: {reason}; update or uninstall "
            "the package"
        ) from None


def load_all(group: str) -> Iterator[tuple[str, Any]]:
    """Import everything in a group, with its names.

    What cannot be imported is left out with a line on the terminal, as all else works without it.
    """
    for name, point in registered(group).items():
        try:
            yield name, load(point)
        except UserError as fault:
            say(str(fault))


def load_named(group: str, name: str, what: str) -> Any:
    """Import the entry point of a name; a UserError if no package has it."""
    points = registered(group)
    if name not in points:
        raise unknown(what, name, list(points))
    return load(points[name])


@cache
def _installed() -> Any:
    """Read the entry points of all packages, once: it takes longer than to parse a command."""
    return entry_points()


def _is_foreign(point: EntryPoint) -> bool:
    return not point.value.startswith(("subsea.", "capture."))
