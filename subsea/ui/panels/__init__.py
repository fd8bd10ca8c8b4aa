"""The panels of the inspector (Tu ch. 9): one module with one function for each."""

from collections.abc import Callable

from subsea.ui.context import PanelContext
from subsea.ui.panels import (
    behavior,
    control,
    habits,
    initialisation,
    physics,
    placement,
    time,
)
from subsea.ui.panels import fish_picker as fish_view

Panel = Callable[[PanelContext], None]

PANELS: dict[str, Panel] = {
    "Initialisation": initialisation.panel,
    "Placement": placement.panel,
    "Physics": physics.panel,
    "Behavior": behavior.panel,
    "Habits": habits.panel,
    "Control": control.panel,
    "Fish view": fish_view.panel,
    "Time": time.panel,
}
"""Panels by their names on the bar, in its order."""
