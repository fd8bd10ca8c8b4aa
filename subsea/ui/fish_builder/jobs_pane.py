"""The pane that starts Learn, Record and dives, and shows their progress and results."""

from collections.abc import Callable
from pathlib import Path

from imgui_bundle import imgui

from subsea.fish.species import species_file, species_names
from subsea.ui.fish_builder.jobs import FEWEST, MOST, CaptureJobs
from subsea.ui.gui import QUIET

JOBS_HELP = "Learn finds how to use its muscles. Record takes down its motion, for scenarios."


def draw_jobs(
    jobs: CaptureJobs,
    key: str,
    can_dive: bool,
    starters: dict[str, Callable[[], None] | None],
    text_height: float,
) -> None:
    """Draw the buttons `starters` by name (None: disabled), the progress and the results.

    `key` names the species for a dive.
    """
    for name, start in starters.items():
        imgui.begin_disabled(jobs.running or start is None)
        if imgui.button(name) and start is not None:
            start()
        imgui.end_disabled()
        imgui.same_line()
    if jobs.running:
        if imgui.button("Stop"):
            jobs.stop()
        imgui.same_line()
        imgui.progress_bar(jobs.progress, (-1.0, 0.0), jobs.doing)
    else:
        imgui.begin_disabled(not can_dive)
        if imgui.button("Dive with it"):
            jobs.dive(key)
        imgui.end_disabled()
        imgui.same_line()
        imgui.set_next_item_width(-6.0 * text_height)
        changed, tries = imgui.drag_int("tries to learn", jobs.tries, 2.0, FEWEST, MOST)
        jobs.tries = tries if changed else jobs.tries
    imgui.push_text_wrap_pos(0.0)
    imgui.text_colored((*QUIET, 1.0), jobs.message or JOBS_HELP)
    imgui.pop_text_wrap_pos()


def is_known(path: Path | None) -> bool:
    """Whether commands find this file by its name, not another species."""
    return (
        path is not None
        and path.stem in species_names()
        and species_file(path.stem).resolve() == path.resolve()
    )
