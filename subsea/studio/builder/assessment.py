"""Checking, test-swimming and painting a draft in the background, and the list of findings."""

from typing import NamedTuple

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from subsea.base.errors import UserError
from subsea.fish.color_sheet import sheet_of
from subsea.fish.paint import paint
from subsea.fish.species import UnstableSpecies
from subsea.repertoire.findings import FishFinding, Severity
from subsea.studio.builder.views import textured_view
from subsea.studio.checks import static_checks, swim_checks, try_swimming
from subsea.studio.draft import SpeciesDraft, with_sheet_path
from subsea.studio.handles import Box
from subsea.ui.gui import colour, wrapped_text

Picture = NDArray[np.uint8]

BADGES = {
    Severity.GOOD: ("ok", (0.45, 0.85, 0.55)),
    Severity.WARNING: ("!", (1.0, 0.80, 0.32)),
    Severity.FAULT: ("x", (1.0, 0.45, 0.36)),
}


class Assessment(NamedTuple):
    """The findings on a draft, and what it looks like."""

    findings: list[FishFinding]
    sheet: Picture
    backdrop: Picture  # the fish in the side view, of a ray in the top view
    box: Box


def assess(draft: SpeciesDraft) -> Assessment:
    """Check a draft, try how it swims, and paint it."""
    species = draft.species
    findings = static_checks(species)
    stiff = species.form == "boxfish" or isinstance(species, UnstableSpecies)
    if species.muscles and not stiff:
        findings += swim_checks(try_swimming(species.muscles))
    sheet, faults = draft_sheet(draft)
    return Assessment([*findings, *faults], sheet, *textured_view(species, sheet))


def draft_sheet(draft: SpeciesDraft) -> tuple[Picture, list[FishFinding]]:
    """Return the sheet of a draft; a painted one and a finding if its picture is faulty."""
    try:
        return sheet_of(with_sheet_path(draft)), []
    except UserError as fault:
        finding = FishFinding(Severity.FAULT, f"Its picture cannot be used: {fault}.")
        return paint(draft.species), [finding]


def draw_findings(findings: list[FishFinding] | None, muscular: bool) -> None:
    """Draw findings, the worst first; None: not known yet."""
    if findings is None:
        imgui.text_disabled("trying how it swims…")
        return
    for severity, text in sorted(findings, key=lambda one: -one.severity):
        badge, ink = BADGES[severity]
        place, size = imgui.get_cursor_screen_pos(), imgui.get_font_size()
        canvas = imgui.get_window_draw_list()
        x, y = place.x + 0.6 * size, place.y + 0.5 * size
        canvas.add_circle_filled((x, y), 0.55 * size, colour(ink))
        imgui.push_font(None, 0.72 * size)
        box = imgui.calc_text_size(badge)
        canvas.add_text((x - box.x / 2, y - box.y / 2), colour((0.0, 0.08, 0.12)), badge)
        imgui.pop_font()
        imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + 1.6 * size)
        imgui.text_wrapped(text)
    if not muscular:
        wrapped_text("Its spine moves this fish: there are no masses and no muscles to try.")
