"""Edits of more than one point: fins, total mass, model length."""

from typing import Any

import numpy as np

from subsea.biomechanics.body_plan import NODES_AT_STATION
from subsea.fish.surface import along
from subsea.studio.draft import (
    KeyPath,
    SpeciesDraft,
    clip_height,
    round_length,
    with_value,
    with_values,
)
from subsea.studio.handles import CM_DIGITS, FINS


def with_fin(draft: SpeciesDraft, name: str, there: bool) -> SpeciesDraft:
    """Add or remove a fin; a new one is plain, in the colour of the flank."""
    surface, skin = draft.content["surface"], draft.content["skin"]
    if not there:
        return with_value(draft, ("surface", name), None)
    if surface.get(name):
        return draft
    values: dict[KeyPath, Any] = {}
    if name in FINS:
        ridge, sign = (surface["back"], 1.0) if name == "dorsal" else (surface["belly"], -1.0)
        x = np.array([0.35, 0.4, 0.5, 0.6, 0.65]) if sign > 0 else np.linspace(0.55, 0.72, 5)
        tall = np.array([0.0, 0.06, 0.07, 0.05, 0.0]) - 0.005
        edge = np.clip(along(ridge, x) + sign * tall, -1.0, 1.0)
        values["surface", name] = {
            "base": [round_length(x[0]), round_length(x[-1])],
            "edge": [[round_length(a), round_length(b)] for a, b in zip(x, edge, strict=True)],
        }
        colours = name
    else:
        at, height = (0.28, 0.25) if name == "pectoral" else (0.36, 0.75)
        level = float(along(surface["belly"], np.array([at]))[0])
        values["surface", name] = {
            "at": at, "height": clip_height(height * level), "length": 0.12, "width": 0.07,
            "droop": 15.0 if name == "pectoral" else 35.0,
        }  # fmt: skip
        colours = "paddles"
    if colours not in skin:
        values["skin", colours] = {"colour": list(skin["flank"])}
    return with_values(draft, values)


def with_mass(draft: SpeciesDraft, grams: float) -> SpeciesDraft:
    """Scale all masses to a total in grams."""
    masses = draft.content["body"]["masses"]
    now = sum(m * n for m, n in zip(masses, NODES_AT_STATION, strict=True))
    return with_value(draft, ("body", "masses"), [float(f"{m * grams / now:.3g}") for m in masses])


def with_length(draft: SpeciesDraft, cm: float) -> SpeciesDraft:
    """Scale the scaffold to another model length, cm; masses scale as the volume."""
    body = draft.content["body"]
    times = cm / body["stations"][-1]
    scaled: dict[KeyPath, Any] = {
        ("body", key): [round(times * x, CM_DIGITS) for x in body[key]]
        for key in ("stations", "half_widths", "half_heights", "spans")
        if key in body
    }
    scaled["body", "tail_half_height"] = round(times * body["tail_half_height"], CM_DIGITS)
    scaled["body", "masses"] = [float(f"{times**3 * m:.3g}") for m in body["masses"]]
    return with_values(draft, scaled)
