"""Plots written as PNG files with one style, all or none. Needs matplotlib."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from subsea.base.atomic_io import check_folder, replacing
from subsea.base.extras import require
from subsea.base.file_kinds import PICTURE, check_results

DPI = 100
STYLE: dict[str, Any] = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "legend.fontsize": 8,
}

Draw = Callable[[Any], object]  # on an empty matplotlib figure


def check_plots(folder: Path, names: Iterable[str], force: bool) -> None:
    """Raise a UserError before any work if plots of these names cannot be written."""
    require("plot", "plots")
    check_folder(folder)
    check_results([folder / name for name in names], PICTURE, force)


def write_plots(
    folder: Path,
    pages: Mapping[str, Draw],
    check: Callable[[], object] = lambda: None,
    style: dict[str, Any] = STYLE,
) -> list[Path]:
    """Draw a page for each name and return the files; UserError without matplotlib.

    `check`, which may raise, is called before each page and before the files are renamed.
    """
    require("plot", "plots")
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    written = []
    with rc_context(style), ExitStack() as whole:
        for name, draw in pages.items():
            check()
            page = Figure(dpi=DPI, layout="constrained")
            draw(page)
            temporary = whole.enter_context(replacing(folder / name))
            page.savefig(temporary, format="png", metadata={"Software": None})
            written.append(folder / name)
        check()
    return written
