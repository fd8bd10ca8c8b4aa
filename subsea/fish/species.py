"""Species files: `assets/species/NAME.toml`, or a user's own."""

import re
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import numpy as np
from msgspec import structs

from subsea.base.errors import UserError
from subsea.base.system import (
    is_path,
    own_path,
    resource_names,
    resource_path,
    stems,
    unknown_name,
)
from subsea.base.toml_files import load_toml
from subsea.biomechanics.body_plan import BodyPlan, Muscles, SwimPlan, TurnPlan
from subsea.biomechanics.rowing import RowPlan
from subsea.biomechanics.solver import check_step
from subsea.fish.character import CharacterPlan
from subsea.fish.forms import Form
from subsea.fish.spine import SpinePlan
from subsea.fish.surface import Curve, Extent, Share, SurfacePlan, along

SHIPPED = "assets/species"  # folder of shipped species

Positive = Annotated[float, msgspec.Meta(ge=1e-4)]  # body lengths
BEHIND_EYE = 0.16  # body lengths that cheek and gills need, at least
EYE_RADIUS = 0.001, 0.25  # body lengths
LEAST_SIZE = 1e-6  # of the sizes of a body, cm, and of its masses
Count = Annotated[int, msgspec.Meta(ge=0, le=60)]
Width = Annotated[float, msgspec.Meta(ge=1e-4, le=1)]
Around = Annotated[float, msgspec.Meta(ge=-3, le=3)]  # body lengths, on the body or beside it
Colour = tuple[Share, Share, Share]  # linear RGB
CruiseHeight = Annotated[float, msgspec.Meta(ge=0.1, le=50)]  # body lengths
BodyLength = Annotated[float, msgspec.Meta(ge=2, le=300)]  # cm
Place = tuple[Share, Extent]  # (distance from the snout, height above the axis), body lengths


class Cape(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A colour on the body above a line along it."""

    colour: Colour
    line: Curve  # (distance from the snout, height; 1 is the dorsal ridge, -1 the ventral)
    soft: Width = 0.12  # half the width of its border, as a fraction of the height


class Stripes(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Stripes along the body, or with `upright` from back to belly, in body lengths."""

    colour: Colour
    spacing: Positive
    share: Share  # coloured fraction of the spacing
    rise: Extent = 0.0  # slope: rise per length tailward; if upright, tailward per length of height
    begin: Share  # distance from the snout
    end: Share = 1.0
    upright: bool = False

    def __post_init__(self) -> None:
        """Refuse stripes that end before they begin."""
        if self.begin >= self.end:
            raise ValueError("stripes must end behind where they begin")


class SkinPatch(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A spot with a smooth outline: points (distance from the snout, height), body lengths."""

    outline: Annotated[list[tuple[Around, Around]], msgspec.Meta(min_length=3)]
    colour: Colour
    rim: Colour | None = None
    rim_width: Width = 0.008
    soft: Width = 0.004  # width of the border
    over_fins: bool = False  # it continues on the fins, under their rays


class SkinSpots(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Round spots scattered on the upper side of a body with wings, in body lengths."""

    colour: Colour
    radius: tuple[Positive, Positive]  # smallest and largest
    spacing: Annotated[float, msgspec.Meta(ge=0.005, le=1)]
    rings: Share = 0.0  # fraction of the larger ones that are rings

    def __post_init__(self) -> None:
        """Refuse spots that run into one another."""
        if not self.radius[0] <= self.radius[1] <= 0.5 * self.spacing:
            raise ValueError("radius must name the smaller first, and at most half the spacing")


class FinSkin(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The colours of a fin; its root has the body's colour."""

    colour: Colour
    opacity: Share = 0.8  # at the edge
    rim: Colour | None = None
    rim_width: Width = 0.012  # body lengths; of paired fins a fraction of their length
    striped: bool = False  # the body's stripes continue on it
    spines: Count = 0  # stiff rays in front, with notches in the membrane between them
    soft_rays: Count = 16  # forked rays behind them


class Variation(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Variation between the fishes of a species."""

    hue: Share = 0.07  # relative change of a primary colour
    saturation: Share = 0.16
    brightness: Share = 0.13
    pattern: Annotated[float, msgspec.Meta(ge=0, le=0.05)] = 0.009  # displacement, body lengths
    torn: Share = 0.12  # fraction with a nick in the dorsal fin
    scarred: Share = 0.2  # fraction with an old scar on a flank


class CourtshipColours(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Colours of a courting male (Tu §5.3): colours near one change to another."""

    of: Colour
    to: Colour
    reach: Annotated[float, msgspec.Meta(ge=0.001, le=2)] = 0.35  # distance from `of`, linear RGB
    saturation: Annotated[float, msgspec.Meta(ge=0, le=3)] = 1.0  # factor for all colours
    brightness: Annotated[float, msgspec.Meta(ge=0, le=3)] = 1.0


class SkinPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The colours of a species, painted in the order of the fields."""

    # A picture beside the file in place of a painted sheet; `load_species` makes the path absolute.
    sheet: Annotated[str, msgspec.Meta(pattern=r"^[^/\\]+\.png$")] | None = None
    back: Colour
    flank: Colour
    belly: Colour
    stripes: Stripes | None = None
    cape: Cape | None = None
    patches: list[SkinPatch] = []
    spots: SkinSpots | None = None
    tail: FinSkin
    dorsal: FinSkin | None = None
    ventral: FinSkin | None = None
    paddles: FinSkin | None = None  # pectoral and pelvic
    iris: Colour
    gloss: Share  # reflectance of the scales
    silver: Share = 0.0  # reflectance of pale parts of the flanks
    scales: Share = 1.0  # contrast of the scales
    rays: Share = 1.0  # contrast of the fin rays
    gills: Annotated[int, msgspec.Meta(ge=0, le=7)] = 1  # 0 a pore, 1 a gill cover, else slits
    pupil: Share = 0.55  # fraction of the eye's radius
    mouth: tuple[Place, Place] = ((0.0, -0.01), (0.03, -0.0184))  # its tip and its corner
    clear_back: Share = 0.0  # transparency of the back
    blotches: Share = 0.5  # strength of the colour noise
    variation: Variation = Variation()
    display: CourtshipColours | None = None

    def __post_init__(self) -> None:
        """Refuse a mouth that does not open forward."""
        if self.mouth[1][0] - self.mouth[0][0] < 0.001:
            raise ValueError("the corner of the mouth must lie 0.001 behind its tip, or more")


Food = Literal["turf", "polyps", "sponges", "rubble"]  # the first of `state.SITES`


class LifePlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The life of a species on stone and among corals."""

    eats: list[Food] = []  # on stone; without it, or out of its sight, it eats plankton or prey
    hides: bool = False  # under overhangs and in corals, at a shadow
    bathes: bool = False  # in an anemone near its home
    cleans: bool = False  # others, at a station on a large coral
    territory_cm: Annotated[float, msgspec.Meta(ge=1, le=1000)] | None = None  # about its home


class Species(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One species, driven by muscles (tables body, swim and turn) or by its spine."""

    name: str
    scientific_name: str
    kind: Literal["pacifist", "prey", "predator"]
    form: Form = "fish"  # how its body swims
    schooling: bool
    size_cm: tuple[BodyLength, BodyLength]  # smallest and largest adults
    pace: Annotated[float, msgspec.Meta(ge=0.25, le=4)] = (
        1.0  # recorded frames a tick, at this size
    )
    least_speed: Share = 0.0  # of a ram ventilator, share of the fast swim's
    home_cm: Annotated[float, msgspec.Meta(ge=1, le=1e4)] | None = None  # farthest from its home
    # Lowest and highest cruise over the ground, body lengths; None: at any height.
    cruise_height: tuple[CruiseHeight, CruiseHeight] | None = None
    character: CharacterPlan = CharacterPlan()
    scavenges: bool = False  # follows the odour of bait and blood; predators always do
    body: BodyPlan | None = None
    swim: SwimPlan | None = None
    turn: TurnPlan | None = None
    row: RowPlan | None = None  # of a species that rows with its pectoral fins
    spine: SpinePlan | None = None
    surface: SurfacePlan
    skin: SkinPlan
    life: LifePlan = LifePlan()

    def __post_init__(self) -> None:
        """Refuse tables that contradict each other, and a body that is unstable."""
        self._check_tables()
        if self.body:
            check_step(self.body)

    def _check_tables(self) -> None:
        if not self.name:
            raise ValueError("`name` is empty, expected the common name")
        given = sum(table is not None for table in (self.body, self.swim, self.turn))
        if given != (3 if self.spine is None else 0):
            raise ValueError("expected the tables [body], [swim] and [turn], or [spine] alone")
        _check_eye(self.surface)
        for key in ("half_widths", "half_heights", "tail_half_height", "masses", "spans"):
            sizes = getattr(self.body, key, None) or 1.0
            if (min(sizes) if isinstance(sizes, tuple) else sizes) < LEAST_SIZE:
                raise ValueError(f"[body] {key}: expected numbers of at least {LEAST_SIZE:g}")
        if self.life.territory_cm and not self.home_cm:
            raise ValueError("[life] territory_cm needs home_cm: a territory is about a home")
        if self.form != "fish" and not self.muscles:
            raise ValueError(f'form = "{self.form}" needs the tables [body], [swim] and [turn]')
        if self.form == "boxfish" and not self.row:
            raise ValueError('form = "boxfish" needs [row]: its pectoral fins drive it')
        if self.row and not (self.muscles and self.surface.pectoral):
            raise ValueError("[row] needs muscles and [surface] pectoral")
        if self.spine and self.spine.wings and not self.surface.wing:
            raise ValueError("[spine.wings] needs the outline [surface.wing]")
        if self.skin.spots and not self.surface.wing:
            raise ValueError("[skin.spots] are for bodies with [surface.wing]")
        if self.size_cm[0] > self.size_cm[1]:
            raise ValueError("size_cm must name the smallest length first")
        if self.cruise_height and self.cruise_height[0] > self.cruise_height[1]:
            raise ValueError("cruise_height must name the lowest height first")
        for fin in ("dorsal", "ventral", "pectoral", "pelvic"):
            colours = fin if fin in ("dorsal", "ventral") else "paddles"
            if getattr(self.surface, fin) and not getattr(self.skin, colours):
                raise ValueError(f"the {fin} fin has no colours: [skin.{colours}] is missing")

    @property
    def muscles(self) -> Muscles | None:
        """Body, swim and turn of a muscle-driven species; None for a spine-driven one."""
        if self.body and self.swim and self.turn:
            return Muscles(self.body, self.swim, self.turn)
        return None

    @property
    def length_cm(self) -> float:
        """Body length of the recorded fish."""
        plan = self.body or self.spine
        assert plan
        return plan.length


def _check_eye(surface: SurfacePlan) -> None:
    """Refuse an eye that is not on the head or too large, so that it could not be painted.

    The plans of body and surface do without these bounds, as their text identifies recordings.
    """
    at, height, radius = surface.eye.at, surface.eye.height, surface.eye.radius
    wing = surface.wing
    end = min(surface.tail.begin, wing.outline[-1][0] if wing else 1.0, 0.66) - BEHIND_EYE
    if at > end:
        raise ValueError(f"`at` of the eye is {at:g}, expected at most {end:.3g}, on the head")
    if not EYE_RADIUS[0] <= radius <= EYE_RADIUS[1]:
        least, most = EYE_RADIUS
        raise ValueError(f"`radius` of the eye is {radius:g}, expected {least:g} to {most:g}")
    low, high = 0.0, wing.span if wing else 0.0
    if not wing:
        low, high = (float(along(curve, np.array(at))) for curve in (surface.belly, surface.back))
    if not low - radius <= height <= high + radius:
        raise ValueError(
            f"`height` of the eye is {height:g}, expected {low:.3g} to {high:.3g}, on the body"
        )


class UnstableSpecies(Species, frozen=True):
    """A species whose body may be unstable: the builder shows and mends it."""

    def __post_init__(self) -> None:
        """Refuse tables that contradict each other."""
        self._check_tables()


def shipped_species() -> list[str]:
    """The names of shipped species, sorted."""
    return resource_names(SHIPPED, ".toml")


def own_species() -> Path:
    """The folder of the user's own species, which may not exist."""
    return own_path("species")


def species_names() -> list[str]:
    """Names that `load_species` knows: shipped ones, then the user's; files may be damaged."""
    shipped = shipped_species()
    return shipped + [name for name in stems(own_species(), ".toml") if name not in shipped]


def hidden_names() -> list[str]:
    """Names of own files that shipped species of the same name hide."""
    return sorted(set(stems(own_species(), ".toml")).intersection(shipped_species()))


def is_shipped(name: str) -> bool:
    """True if the species `name` is shipped."""
    return name in shipped_species()


def species_file(name: str) -> Path:
    """The file of the species `name`, or the path `name`; UserError for an unknown name."""
    if is_path(name, ".toml"):
        return Path(name)
    _check_known(name, ".toml")
    return (resource_path(SHIPPED) if is_shipped(name) else own_species()) / f"{name}.toml"


def own_species_file(name: str) -> Path:
    """The path of the user's species `name`, which may not exist.

    UserError for the name of a shipped species or one that is not a word.
    """
    if is_shipped(name):
        raise UserError(f"the name {name!r} is that of a shipped species, expected another")
    if not re.fullmatch(r"\w[\w-]*", name):
        raise UserError(f"the name {name!r}: expected only letters, digits, _ and -")
    return own_species() / f"{name}.toml"


def repertoire_folder(name: str) -> Path:
    """The repertoire folder of the species `name`, which may not exist."""
    return resource_path("repertoires") if is_shipped(name) else own_path("repertoires")


def repertoire_file(name: str) -> Path:
    """The repertoire of the species `name`, or the path `name`; UserError for an unknown name."""
    if is_path(name, ".h5"):
        return Path(name)
    _check_known(name, ".h5")
    return repertoire_folder(name) / f"{name}.h5"


def muscular_names() -> list[str]:
    """The shipped species with muscles, which can be simulated."""
    return [name for name in shipped_species() if load_species(name).muscles]


def load_species(name: str) -> Species:
    """The species `name`; UserError for an unknown name or a faulty file."""
    path = species_file(name)
    species = load_toml(path, Species)
    if not (sheet := species.skin.sheet):
        return species
    skin = structs.replace(species.skin, sheet=str(path.absolute().with_name(sheet)))
    return structs.replace(species, skin=skin)


def _check_known(name: str, suffix: str) -> None:
    if name not in (known := species_names()):
        raise unknown_name("species", name, known, suffix)
