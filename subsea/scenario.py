"""Scenarios: who lives where, from `assets/scenarios/NAME.toml`."""

from pathlib import Path
from typing import Annotated

import msgspec

from subsea.errors import UserError, unknown
from subsea.resources import load_toml, named_or_file
from subsea.species import BodyLength, species_names

MAX_FISHES = 100_000
# Two rows each in a texture, whose height OpenGL drivers limit to 16384 or less.
MAX_SIMULATED = 4000
Positive = Annotated[float, msgspec.Meta(gt=0, le=1e5)]
Coordinate = Annotated[float, msgspec.Meta(ge=-1e5, le=1e5)]
Seed = Annotated[int, msgspec.Meta(ge=0, le=2**32 - 1)]
Flow = Annotated[float, msgspec.Meta(ge=-200, le=200)]
Share = Annotated[float, msgspec.Meta(ge=0, le=1)]
Colour = tuple[Share, Share, Share]


class Bounds(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The sea is a cylinder: from the seabed at about -depth_cm up to the surface at z = 0."""

    radius_cm: Annotated[float, msgspec.Meta(ge=300, le=20000)]
    depth_cm: Annotated[float, msgspec.Meta(ge=200, le=5000)]


class Water(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How the water looks and moves."""

    fog: Colour  # linear RGB of the far water, seen level
    visibility_cm: Annotated[
        float, msgspec.Meta(ge=50, le=1e5)
    ]  # distance at which contrast has fallen to 2%
    current_cm_s: tuple[Flow, Flow] = (0.0, 0.0)  # uniform flow along x and y
    plankton: Annotated[int, msgspec.Meta(ge=0, le=100000)] = 0


class Terrain(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The height field of the seabed."""

    dune_height_cm: Annotated[float, msgspec.Meta(ge=0, le=400)]
    dune_length_cm: Annotated[float, msgspec.Meta(ge=50, le=1e5)]
    seed: Seed = 0


class Shoal(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Fishes of one species that start together."""

    species: str
    number: Annotated[int, msgspec.Meta(ge=0, le=MAX_FISHES)]
    size_cm: tuple[BodyLength, BodyLength] | None = None  # smallest and largest; none: the species'
    position_cm: tuple[Coordinate, Coordinate, Coordinate] | None = (
        None  # centre; none: spread over the sea
    )
    spread_cm: Positive = 150.0


class Start(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Where the submarine begins."""

    position_cm: tuple[Coordinate, Coordinate, Coordinate]
    heading_deg: Coordinate = 0.0


class Scenario(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Everything that a dive starts from."""

    title: str
    seed: Seed
    bounds: Bounds
    water: Water
    terrain: Terrain
    submarine: Start
    fish: Annotated[list[Shoal], msgspec.Meta(min_length=1)]
    # So many of the nearest fishes are simulated instead of played back.
    simulated: Annotated[int, msgspec.Meta(ge=0, le=MAX_SIMULATED)] = 0


def load_scenario(name: str) -> tuple[Scenario, Path]:
    """The scenario called `name`, or the one in the file `name`, and the file it came from."""
    path = named_or_file(name, "assets/scenarios", ".toml", "scenario")
    scenario = load_toml(path, Scenario)
    known = species_names()
    _inside(path, "submarine.position_cm", scenario.submarine.position_cm, scenario.bounds)
    for k, shoal in enumerate(scenario.fish):
        if shoal.species not in known:
            raise UserError(f"{path}: {unknown('species', shoal.species, known)}")
        if shoal.size_cm is not None and shoal.size_cm[0] > shoal.size_cm[1]:
            raise UserError(f"{path}: size_cm {shoal.size_cm} of {shoal.species}: smallest first")
        if shoal.position_cm is not None:
            _inside(path, f"fish[{k}].position_cm", shoal.position_cm, scenario.bounds)
    number = sum(shoal.number for shoal in scenario.fish)
    if number > MAX_FISHES:
        raise UserError(f"{path}: {number} fishes in all, expected at most {MAX_FISHES}")
    return scenario, path


def _inside(path: Path, key: str, place: tuple[float, float, float], bounds: Bounds) -> None:
    """A UserError unless `place` lies in the cylinder, between its floor and the surface."""
    x, y, z = place
    if x * x + y * y > bounds.radius_cm**2 or not -bounds.depth_cm <= z <= 0:
        raise UserError(
            f"{path}: `{key}` {place} lies outside the sea: expected at most "
            f"{bounds.radius_cm:g} cm from the middle and 0 to {-bounds.depth_cm:g} cm high"
        )
