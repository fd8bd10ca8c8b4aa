"""The record of a simulation: its datasets, and reading one (docs/reference/records.md)."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base import hdf5
from subsea.base.arrays import Array, Bools, Ints
from subsea.base.errors import UserError
from subsea.base.file_kinds import hdf5_file
from subsea.base.system import require
from subsea.fish.surface import SurfacePlan, along

FORMAT, VERSION = "subsea-record", 2
RECORD = hdf5_file("a record", FORMAT)
STATIONS = 13  # points of a body's outline, from the snout to the tail's edge
SNOUTWARD = np.float32(0.2)  # place of the centre of mass in records of earlier versions, roughly
PERIODS = ("period_x_cm", "period_y_cm")  # attributes of a record from a box
MAX_FISH_TICKS = 20_000_000  # a study holds them in memory: about 2 GB


# Each dimension is an HDF5 dimension scale at this path; its length if that is always the same.
DIMENSIONS: dict[str, tuple[str, int | None]] = {
    "time": ("time", None),
    "axis": ("axis", 3),
    "fish": ("fish/fish", None),
    "component": ("fish/component", 4),
    "drive": ("fish/drive", 3),
    "species": ("species/species", None),
    "station": ("species/station", STATIONS),
    "y": ("sea/y", None),
    "x": ("sea/x", None),
    "pillar": ("sea/pillar", None),
    "pillar_value": ("sea/pillar_value", 4),
    "rock": ("sea/rock", None),
    "rock_value": ("sea/rock_value", 7),
    "event": ("direction/event", None),
    "role": ("direction/role", 2),
}


class DatasetSpec(NamedTuple):
    """Type, dimensions, unit and meaning of one dataset."""

    type: type
    dimensions: tuple[str, ...]  # names in DIMENSIONS
    unit: str  # as UDUNITS writes it; "1" if dimensionless, "" for words
    meaning: str


_BY_TICK, _BY_FISH, _BY_EVENT = ("time",), ("fish",), ("event",)
_BOTH = *_BY_TICK, *_BY_FISH
FIELDS = {
    "time": DatasetSpec(np.float64, _BY_TICK, "s", "end of the tick, from the start of the dive"),
    "fish/position": DatasetSpec(np.float32, (*_BOTH, "axis"), "cm", "origin of the body frame"),
    "fish/orientation": DatasetSpec(
        np.float32, (*_BOTH, "component"), "1",
        "unit quaternion w, x, y, z from body axes (x to the snout, y to the back, z right) to"
        " world axes",
    ),
    "fish/velocity": DatasetSpec(
        np.float32, (*_BOTH, "axis"), "cm s-1",
        "velocity of the origin, of a simulated fish that of its centre of mass",
    ),
    "fish/snout": DatasetSpec(
        np.float32, (*_BOTH, "axis"), "cm", "tip of the snout of the bent body"
    ),
    "fish/tail": DatasetSpec(np.float32, (*_BOTH, "axis"), "cm", "middle of the tail's edge"),
    "fish/centre": DatasetSpec(
        np.float32, (*_BOTH, "axis"), "cm", "centre of mass of the bent body"
    ),
    "fish/intention": DatasetSpec(np.uint8, _BOTH, "1", "index into intention_names"),
    "fish/segment": DatasetSpec(
        np.uint8, _BOTH, "1", "recorded motion that it plays: index into segment_names"
    ),
    "fish/mental_state": DatasetSpec(
        np.float32, (*_BOTH, "drive"), "1", "hunger, libido and fear, 0 to 1"
    ),
    "fish/alive": DatasetSpec(np.bool_, _BOTH, "1", "false once it is eaten or landed"),
    "fish/leader": DatasetSpec(
        np.int32, _BOTH, "1", "fish that it follows in a school, -1 for none"
    ),
    "fish/target": DatasetSpec(
        np.int32, _BOTH, "1",
        "target of the intention: a fish, or a speck of plankton (target_names);"
        " -1 nothing, -2 the submarine, -3 a bait",
    ),
    "fish/partner": DatasetSpec(np.int32, _BOTH, "1", "fish that it courts, -1 for none"),
    "fish/courtship": DatasetSpec(np.uint8, _BOTH, "1", "index into courtship_names"),
    "fish/last_meal": DatasetSpec(
        np.float32, _BOTH, "s", "time of the latest meal, 0 before the first"
    ),
    "fish/species": DatasetSpec(
        np.uint8, _BY_FISH, "1", "index into species_names (common names) and species_keys (files)"
    ),
    "fish/kind": DatasetSpec(np.uint8, _BY_FISH, "1", "index into kind_names"),
    "fish/male": DatasetSpec(np.bool_, _BY_FISH, "1", "true for males"),
    "fish/schools": DatasetSpec(np.bool_, _BY_FISH, "1", "true if it likes schooling"),
    "fish/length": DatasetSpec(np.float32, _BY_FISH, "cm", "from the snout to the tail's edge"),
    "fish/snout_reach": DatasetSpec(
        np.float32, _BY_FISH, "cm", "from the tip of the snout to the origin of the body frame"
    ),
    "species/half_width": DatasetSpec(
        np.float32, ("species", "station"), "1",
        "half-width of the body without fins, in body lengths",
    ),
    "species/half_height": DatasetSpec(
        np.float32, ("species", "station"), "1", "half-height with the tail fin, in body lengths"
    ),
    "sea/heights": DatasetSpec(
        np.float32, ("y", "x"), "cm",
        "z of the seabed",
    ),
    "sea/pillars": DatasetSpec(
        np.float64, ("pillar", "pillar_value"), "cm", "x, y, radius and z of the top of each pillar"
    ),
    "sea/rocks": DatasetSpec(
        np.float64, ("rock", "rock_value"), "cm",
        "centre x, y, z and half axes of each ellipsoid, and its rotation to the left in rad",
    ),
    "plankton/count": DatasetSpec(np.int32, _BY_TICK, "1", "specks of plankton"),
    "day/hour": DatasetSpec(np.float32, _BY_TICK, "h", "hour of the day, 0 to 24"),
    "submarine/position": DatasetSpec(
        np.float64, ("time", "axis"), "cm", "position of the submarine"
    ),
    "direction/began": DatasetSpec(
        np.float64, _BY_EVENT, "s", "end of the tick in which a direction began"
    ),
    "direction/number": DatasetSpec(
        np.uint8, _BY_EVENT, "1", "index of the direction in the scenario and in direction_names"
    ),
    "direction/cast": DatasetSpec(
        np.int32, ("event", "role"), "1",
        "fishes of the event: male and female, hunter and prey, eaten and eater, or fleeing fish"
        " and predator; -1 none, -2 the submarine",
    ),
}  # fmt: skip
COORDINATES = {
    "axis": DatasetSpec(str, ("axis",), "", "world axes; z is up, and the surface is z = 0"),
    "fish/fish": DatasetSpec(np.int32, _BY_FISH, "1", "number of the fish"),
    "fish/component": DatasetSpec(str, ("component",), "", "components of a quaternion"),
    "fish/drive": DatasetSpec(str, ("drive",), "", "variables of the mental state"),
    "species/species": DatasetSpec(str, ("species",), "", "common name"),
    "species/station": DatasetSpec(
        np.float64, ("station",), "1", "from the snout (0) to the tail's edge (1)"
    ),
    "sea/y": DatasetSpec(
        np.float64, ("y",), "cm", "y, evenly from -sea_half_width_cm to sea_half_width_cm"
    ),
    "sea/x": DatasetSpec(np.float64, ("x",), "cm", "x, likewise"),
    "sea/pillar_value": DatasetSpec(str, ("pillar_value",), "", "numbers of a pillar"),
    "sea/rock_value": DatasetSpec(str, ("rock_value",), "", "numbers of a rock"),
}
"""The coordinates, beside `time`: labels and places along the dimensions of FIELDS."""


NO_PERIOD = np.zeros(2)


class Record(NamedTuple):
    """The parts of a record that a study needs: T ticks of n fishes of s species."""

    time: Array  # (T,) s
    position: Array  # (T, n, 3) cm
    orientation: Array  # (T, n, 4)
    snout: Array  # (T, n, 3) cm
    tail: Array  # (T, n, 3) cm
    centre: Array  # (T, n, 3) cm
    intention: Ints  # (T, n)
    segment: Ints  # (T, n)
    mental_state: Array  # (T, n, 3)
    alive: Bools  # (T, n)
    leader: Ints  # (T, n)
    target: Ints  # (T, n)
    partner: Ints  # (T, n)
    courtship: Ints  # (T, n)
    last_meal: Array  # (T, n) s
    species: Ints  # (n,)
    kind: Ints  # (n,)
    male: Bools  # (n,)
    length: Array  # (n,) cm
    snout_reach: Array  # (n,) cm
    half_width: Array  # (s, STATIONS) body lengths
    half_height: Array  # (s, STATIONS) body lengths
    heights: Array  # (m, m) cm
    pillars: Array  # (p, 4) cm
    rocks: Array  # (r, 7) cm and rad
    plankton: Ints  # (T,)
    tick_s: float
    seed: int
    radius_cm: float
    half_width_cm: float  # of the seabed's square
    alarmed: float  # f0: fear above it is alarm
    species_names: list[str]
    intention_names: list[str]
    segment_names: list[str]
    mental_state_names: list[str]
    courtship_names: list[str]
    kind_names: list[str]
    species_keys: tuple[str, ...] = ()  # as scenarios name the species; older records have none
    # (2,) cm, of a box with periodic sides along x and y, or 0. Places go on beyond its sides.
    period: Array = NO_PERIOD

    @property
    def keys(self) -> list[str]:
        """The species as scenarios name them, or their common names with underscores."""
        names = [name.lower().replace(" ", "_") for name in self.species_names]
        return [*self.species_keys] or names

    @property
    def individuals(self) -> list[str]:
        """A name for each fish: its species and number, such as ``fusilier_3``."""
        keys = self.keys
        return [f"{keys[kind]}_{i}" for i, kind in enumerate(self.species)]

    @property
    def period_attributes(self) -> dict[str, float]:
        """The period by the names of a file's attributes, cm; empty without a box."""
        return dict(zip(PERIODS, self.period.tolist(), strict=True)) if self.period[0] else {}

    @property
    def body_points(self) -> tuple[tuple[str, ...], Array]:
        """Names and places (T, n, k, 3), cm, of the k points of a body that a record has."""
        return ("snout", "centre", "tail"), np.stack([self.snout, self.centre, self.tail], axis=2)

    def to_movement(self) -> Any:
        """Make a dataset of poses for the package `movement`.

        Returns:
            An `xarray.Dataset` with `position` (time, space, keypoints, individuals), cm, and
            `confidence` (time, keypoints, individuals), 1. Keypoints are snout, centre of mass and
            tail; individuals have names such as ``fusilier_3``. Both arrays are NaN after the death
            of a fish. Time is in s, z is up, and the surface is at 0. In a box with periodic sides
            paths go on beyond its sides, and the attributes `period_x_cm` and `period_y_cm` tell
            its lengths.

        Raises:
            UserError: xarray is not installed (extra `tracks`).

        Examples:
            >>> path = subsea.simulate("peaceful", "run.h5", seconds=0.33, seed=1, fish=10)
            >>> dict(subsea.open_record(path).to_movement().sizes)
            {'time': 10, 'space': 3, 'keypoints': 3, 'individuals': 10}
        """
        require("tracks", "Record.to_movement")
        import xarray

        names, points = self.body_points
        there = self.alive[..., None]
        position = np.where(there[..., None], points, np.nan).transpose(0, 3, 2, 1)
        sure = np.where(np.broadcast_to(there, points.shape[:3]), 1.0, np.nan).transpose(0, 2, 1)
        dimensions = ("time", "space", "keypoints", "individuals")
        return xarray.Dataset(
            {
                "position": (dimensions, position.astype(np.float32), {"units": "cm"}),
                "confidence": (("time", *dimensions[2:]), sure.astype(np.float32)),
            },
            {
                "time": ("time", self.time, {"units": "s"}),
                "space": [*"xyz"],
                "keypoints": [*names],
                "individuals": self.individuals,
            },
            {
                "source_software": "subsea", "ds_type": "poses", "fps": 1.0 / self.tick_s,
                "time_unit": "seconds",
                **self.period_attributes,
            },
        )  # fmt: skip


BY_MINDS = ("minds",)  # of a record in which nobody interferes


class Origin(NamedTuple):
    """The inputs of a record, except its seed; without a hash if its version is older."""

    title: str
    scenario_sha256: str
    changes: tuple[str, ...]
    fish: int
    moved_by: tuple[str, ...] = BY_MINDS


# Fields of Record that are datasets, and names that differ from the end of the path.
_RENAMED = {"plankton/count": "plankton"}
READ = {
    name: path
    for path in FIELDS
    if (name := _RENAMED.get(path, path.rpartition("/")[2])) in Record._fields
    and not path.startswith(("submarine/", "direction/"))
}
_CODED = (
    ("intention", "intention_names"), ("segment", "segment_names"),
    ("courtship", "courtship_names"), ("species", "species_names"), ("kind", "kind_names"),
)  # fmt: skip


def outline(surface: SurfacePlan) -> tuple[Array, Array]:
    """Compute half-widths and half-heights (STATIONS,) of a body at rest, in body lengths.

    Fins except the tail are left out; wings, as of rays, count as body.
    """
    at = np.linspace(0.0, 1.0, STATIONS)
    width = along(surface.width, at)
    if surface.wing:
        behind, right = np.array(surface.wing.outline).T
        width = np.maximum(width, np.interp(at, behind, right, right=0.0))
    height = 0.5 * (along(surface.back, at) - along(surface.belly, at))
    return np.maximum(width, 0.0), np.maximum(height, 0.0)


def read_record(path: Path) -> Record:
    """Read a record; a damaged or foreign file is a UserError."""
    where = str(path)
    with hdf5.reading(path) as file:
        if hdf5.attribute(file, "format", str, where) != FORMAT:
            raise UserError(
                "not a record of a simulation, expected a file of `subsea simulate`", file=where
            )
        version = hdf5.attribute(file, "version", int, where)
        if version != VERSION:
            raise UserError(
                f"version {version} of the format, expected {VERSION}; record it again", file=where
            )
        lengths: dict[str, int] = {}
        first = ("time", "fish/species", *READ.values())
        older = not hdf5.has_member(hdf5.subgroup(file, "fish", where), "centre")
        read = {
            dataset: _dataset(file, dataset, lengths, where)
            for dataset in first
            if not (older and dataset == "fish/centre")
        }
        if older:
            snout, origin = read["fish/snout"], read["fish/position"]
            read["fish/centre"] = origin + SNOUTWARD * (snout - origin)
        fields: dict[str, Any] = {name: read[dataset] for name, dataset in READ.items()}
        names = [name for name in Record._fields if name.endswith("_names")]
        record = Record(
            **fields | {name: hdf5.texts(file, name, where) for name in names},
            tick_s=hdf5.attribute(file, "tick_s", float, where),
            seed=hdf5.attribute(file, "seed", int, where),
            radius_cm=hdf5.attribute(file, "radius_cm", float, where),
            half_width_cm=hdf5.attribute(file, "sea_half_width_cm", float, where),
            alarmed=hdf5.attribute(file, "nature_alarmed", float, where),
            species_keys=tuple(
                hdf5.texts(file, "species_keys", where)
                if hdf5.has_attribute(file, "species_keys")
                else ()
            ),
            period=_period(file, where),
        )
    _check(record, where)
    return record


def _period(file: Any, where: str) -> Array:
    """Read the period of the box (2,); zeros of a record without one."""
    if not hdf5.has_attribute(file, PERIODS[0]):
        return NO_PERIOD
    period = np.array([hdf5.attribute(file, name, float, where) for name in PERIODS])
    if not (np.isfinite(period) & (period > 0)).all():
        raise UserError(f"{' and '.join(PERIODS)}: expected lengths above 0", file=where)
    return period


def read_origin(path: Path) -> Origin:
    """Read the origin of a record; a damaged file is a UserError."""
    where = str(path)
    with hdf5.reading(path) as file:
        number = hdf5.attribute(file, "fish", int, where)
        if not hdf5.has_attribute(file, "scenario_sha256"):
            return Origin("", "", (), number)
        changes = hdf5.texts(file, "changes", where)
        return Origin(
            title=hdf5.attribute(file, "title", str, where),
            scenario_sha256=hdf5.attribute(file, "scenario_sha256", str, where),
            changes=tuple(one for one in changes if one.partition("=")[0].strip() != "seed"),
            fish=number,
            moved_by=tuple(hdf5.texts(file, "moved_by", where))
            if hdf5.has_attribute(file, "moved_by")
            else BY_MINDS,
        )


def _dataset(file: Any, path: str, lengths: dict[str, int], where: str) -> NDArray[Any]:
    """Read a dataset of FIELDS; the first ones determine the `lengths` of the rest."""
    field = FIELDS[path]
    shape = tuple(lengths.get(name, DIMENSIONS[name][1]) for name in field.dimensions)
    folder, _, name = path.rpartition("/")
    group = hdf5.subgroup(file, folder, where) if folder else file
    values = hdf5.array(
        group, name, shape, f"{where}/{folder}" if folder else where,
        kind=np.dtype(field.type).kind,  # type: ignore[arg-type]
        least=0 if folder == "sea" else 1,
        most_bytes=16 * MAX_FISH_TICKS,
    )  # fmt: skip
    lengths.update(zip(field.dimensions, values.shape, strict=True))
    if lengths.get("time", 0) * lengths.get("fish", 0) > MAX_FISH_TICKS:
        raise UserError(
            f"{lengths['time']} ticks of {lengths['fish']} fishes are too many for one study, "
            f"expected at most {MAX_FISH_TICKS:,} ticks × fishes",
            file=where,
        )
    return values


def _check(record: Record, where: str) -> None:
    """Reject codes without a name, companions that do not exist, and impossible sizes."""
    for field, names in _CODED:
        most = int(getattr(record, field).max())
        if most >= len(getattr(record, names)):
            raise UserError(f"code {most} has no name in `{names}`", file=f"{where}/fish/{field}")
    n = record.position.shape[1]
    for field in ("leader", "partner"):
        values = getattr(record, field)
        if values.min() < -2 or values.max() >= n:
            raise UserError(
                f"expected fishes from 0 to {n - 1}, or -1", file=f"{where}/fish/{field}"
            )
    if len(record.keys) != len(record.species_names):
        raise UserError("expected a key for each of `species_names`", file=where)
    if len(record.species_names) != len(record.half_width):
        raise UserError(
            "expected a row for each of `species_names`", file=f"{where}/species/half_width"
        )
    if record.length.min() <= 0 or record.snout_reach.min() <= 0:
        raise UserError("expected lengths above 0", file=f"{where}/fish/length")
    if record.tick_s <= 0 or record.radius_cm <= 0 or record.half_width_cm <= 0:
        raise UserError("`tick_s`, `radius_cm` and `sea_half_width_cm` must be above 0", file=where)
    if min(record.heights.shape) < 2:
        raise UserError("expected at least 2×2 heights", file=f"{where}/sea/heights")
    if len(record.time) > 1 and np.diff(record.time).min() <= 0:
        raise UserError("expected increasing times", file=f"{where}/time")
