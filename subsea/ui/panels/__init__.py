"""The panels of the inspector (Tu ch. 9): one module with one function for each."""

from collections.abc import Callable

from subsea.ui.panels import (
    behavior,
    control,
    initialisation,
    physics,
    placement,
)
from subsea.ui.panels import fish_picker as fish_view
from subsea.ui.panels.fields import PanelContext

Panel = Callable[[PanelContext], None]

PANELS: dict[str, Panel] = {
    "Initialisation": initialisation.panel,
    "Placement": placement.panel,
    "Physics": physics.panel,
    "Behavior": behavior.panel,
    "Habits": behavior.habits_panel,
    "Control": control.panel,
    "Fish view": fish_view.panel,
    "Time": control.time_panel,
}
"""Panels by their names on the bar, in its order."""
