"""What is constant per species, from `assets/species/NAME.toml`."""

from typing import Literal

import msgspec

from subsea.biomechanics.plan import BodyPlan, SwimPlan, TurnPlan
from subsea.errors import UserError, unknown
from subsea.kinematics.surface import SurfacePlan
from subsea.resources import load_toml, resource_names, resource_path

Colour = tuple[float, float, float]  # linear RGB, 0 to 1


PATTERNS = ("countershaded", "stripes")  # the shader knows them by place


class SkinPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How the species is coloured; `shaders/skin.glsl` draws it."""

    pattern: Literal["countershaded", "stripes"]
    back: Colour
    flank: Colour
    belly: Colour
    fins: Colour
    accent: Colour  # the upper band and tail, or the stripes


class Species(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One species: what it is called, how it is built, how it moves, what it looks like."""

    name: str
    scientific_name: str
    kind: Literal["pacifist", "prey", "predator"]
    schooling: bool
    body: BodyPlan
    swim: SwimPlan
    turn: TurnPlan
    surface: SurfacePlan
    skin: SkinPlan


def species_names() -> list[str]:
    """The species that have a file, sorted."""
    return resource_names("assets/species", ".toml")


def load_species(name: str) -> Species:
    """The species `name`; an unknown name or a faulty file is a UserError in one line."""
    known = species_names()
    if name not in known:
        raise unknown("species", name, known)
    path = resource_path("assets/species") / f"{name}.toml"
    species = load_toml(path, Species)
    if not species.name:
        raise UserError(f"{path}: `name` is empty, expected the common name")
    return species
