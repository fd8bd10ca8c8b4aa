"""Measured swimming of real fishes: the ranges that checks compare with (assets/swimming.toml)."""

from pathlib import Path
from typing import Annotated, Literal

import msgspec

from subsea.base.errors import unknown
from subsea.base.findings import RangeCheck
from subsea.base.system import resource_path
from subsea.base.toml_files import error_at, load_toml

FILE = "swimming.toml"
ITSELF = "itself"

Gait = Literal["body-caudal", "pectoral", "ram", "eel", "ray"]
Wave = Literal["carangiform", "anguilliform", "none"]
Number = Annotated[float, msgspec.Meta(ge=0.0, le=1000.0)]
Word = Annotated[str, msgspec.Meta(min_length=1, max_length=400)]


class MeasuredRange(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A published range of one quantity."""

    range: tuple[Number, Number]
    of: Word  # the measured species, or `ITSELF`
    source: Word  # a key of [sources]
    recalled: bool = False  # not looked up again in the source

    def __post_init__(self) -> None:
        """Refuse an empty range."""
        if self.range[0] >= self.range[1]:
            raise ValueError("range must name the smaller number first")


class SwimmingFacts(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Swimming of one species; lengths in body lengths L, speeds in L/s, angles in degrees."""

    gait: Gait
    wave: Wave  # kind of the published envelope
    slow: MeasuredRange
    cruise: MeasuredRange
    burst: MeasuredRange
    beat: MeasuredRange  # Hz while cruising
    stride: MeasuredRange
    strouhal: MeasuredRange
    amplitude: MeasuredRange | None = None  # of the tail's edge, peak to peak
    slow_amplitude: MeasuredRange | None = None  # of speeds below 2 L/s, as the next
    slow_stride: MeasuredRange | None = None
    wavelength: MeasuredRange | None = None
    radius: MeasuredRange  # of turns at low speed
    gait_change: MeasuredRange | None = None  # speed at which the tail joins the pectoral fins
    escape_angle: MeasuredRange | None = None  # of C-starts; None: it makes none
    escape_duration: MeasuredRange | None = None  # s
    height: MeasuredRange | None = None  # over the ground, of a species that keeps to it


class PostureFacts(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Bodies with a carangiform wave, at every speed and in turns."""

    snout_over_tail: MeasuredRange  # ratio of amplitudes
    wavelength: MeasuredRange  # L
    yaw: MeasuredRange  # degrees, peak to peak, of the head
    snout: MeasuredRange  # degrees, bend of the snout alone
    roll: MeasuredRange  # degrees, to one side
    slope: MeasuredRange  # of the beat over the speed, Hz over L/s
    intercept: MeasuredRange  # Hz
    into_turn: MeasuredRange  # share of bent ticks whose bend is into the turn
    acceleration: MeasuredRange  # L/s², in turns but for escapes


class CoastingFacts(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Drag of a straight body."""

    drag: MeasuredRange  # coefficient on the wetted area


class SchoolFacts(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Schools without alarm, and their fishes."""

    polarisation: MeasuredRange
    disorder: MeasuredRange  # share of the time with a polarisation below one half
    nearest: MeasuredRange  # distance of the nearest neighbour, L: median ...
    near: MeasuredRange  # ... and 5th percentile
    room: MeasuredRange  # volume for each fish, L³
    elevation: MeasuredRange  # of the nearest neighbour above or below, degrees
    oblique: MeasuredRange  # density of the nearest at 45° and 135° over that at 90°
    longer: MeasuredRange  # length over width
    flatter: MeasuredRange  # length over height
    variation: MeasuredRange  # standard deviation of a fish's speed over its mean
    slow: MeasuredRange  # share of the time below half of the own median speed
    gliding: MeasuredRange  # share of the time with a still tail
    split: MeasuredRange  # duration, s


class MindFacts(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Steadiness of minds."""

    short: MeasuredRange  # share of bouts of intention below half a second
    alarm: MeasuredRange  # after the last sight of a predator, s
    flips: MeasuredRange  # passages of fear through the threshold of alarm in a minute


class BudgetFacts(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Shares of active time."""

    feeding: MeasuredRange
    courting: MeasuredRange  # by day
    avoiding: MeasuredRange


class PredationFacts(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Attacks on single fishes and on groups."""

    catches: MeasuredRange  # of one shark in three minutes
    rushes: MeasuredRange  # at close range in three minutes, of a sea made for hunts
    first: MeasuredRange  # start of the first of them, s
    confusion: MeasuredRange  # captures per attack on groups of 20, over those on single fishes


class MeasuredSwimming(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The whole table."""

    sources: dict[str, Word]
    posture: PostureFacts
    coasting: CoastingFacts
    schools: SchoolFacts
    predation: PredationFacts
    minds: MindFacts
    budget: BudgetFacts
    species: dict[str, SwimmingFacts]


def load_measured(path: Path | None = None) -> MeasuredSwimming:
    """Read the shipped table or one at `path`; UserError with the line of a fault."""
    path = path or resource_path("assets") / FILE
    table = load_toml(path, MeasuredSwimming)
    groups = {f"species.{name}": facts for name, facts in table.species.items()}
    for name, group in groups.items() | {
        ("posture", table.posture), ("coasting", table.coasting),
        ("schools", table.schools), ("predation", table.predation),
        ("minds", table.minds), ("budget", table.budget),
    }:  # fmt: skip
        for key in group.__struct_fields__:
            value = getattr(group, key)
            if isinstance(value, MeasuredRange) and value.source not in table.sources:
                fault = unknown("source", value.source, list(table.sources))
                raise error_at(path, f"{name}.{key}", fault.message)
    return table


def measured_species(table: MeasuredSwimming, name: str) -> SwimmingFacts:
    """The facts of a species; UserError for one that the table lacks."""
    if name not in table.species:
        raise unknown("species in assets/swimming.toml:", name, list(table.species))
    return table.species[name]


def published(
    subject: str, quantity: str, value: float, unit: str, measured: MeasuredRange, note: str = ""
) -> RangeCheck:
    """A quantity beside its range; the source says whose it is and if it was recalled."""
    of = "" if measured.of == ITSELF else f" ({measured.of})"
    source = f"{measured.source}{of}{', recalled' if measured.recalled else ''}"
    return RangeCheck(subject, quantity, value, unit, *measured.range, source, note)
