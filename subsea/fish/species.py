"""Constants of a species, from `assets/species/NAME.toml` or a user's file."""

import re
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import structs

from subsea.biomechanics.body_plan import BodyPlan, Muscles, SwimPlan, TurnPlan
from subsea.biomechanics.stability import check_step
from subsea.core.errors import UserError, unknown
from subsea.core.resources import is_path, own_path, resource_names, resource_path, stems
from subsea.core.toml_files import load_toml
from subsea.fish.spine import SpinePlan
from subsea.fish.surface import Curve, Extent, Share, SurfacePlan

SHIPPED = "assets/species"  # the folder of those that come with the program

Positive = Annotated[float, msgspec.Meta(gt=0)]
Count = Annotated[int, msgspec.Meta(ge=0, le=60)]
Width = Annotated[float, msgspec.Meta(gt=0, le=1)]
Around = Annotated[float, msgspec.Meta(ge=-3, le=3)]  # body lengths, on the body or beside it
Colour = tuple[Share, Share, Share]  # linear RGB
BodyLength = Annotated[float, msgspec.Meta(ge=2, le=300)]  # cm
Place = tuple[Share, Extent]  # (distance from the snout, height above the axis), body lengths


class Cape(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A colour over all that lies above a line along the body."""

    colour: Colour
    line: Curve  # (distance from the snout, height; 1 is the dorsal ridge, -1 the ventral)
    soft: Width = 0.12  # half the width of its border, of the height


class Stripes(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Lines along the body, or with `upright` from back to belly, in body lengths."""

    colour: Colour
    spacing: Positive
    share: Share  # of the spacing that the colour takes
    rise: Extent = 0.0  # for each body length tailward a line lies so much higher; if upright,
    # for each body length of height it lies so much further tailward
    begin: Share  # distance from the snout at which they begin
    end: Share = 1.0  # and end
    upright: bool = False

    def __post_init__(self) -> None:
        """Refuse lines that end before they begin."""
        if self.begin >= self.end:
            raise ValueError("stripes must end behind where they begin")


class SkinPatch(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A spot with a smooth outline: points (distance from the snout, height), body lengths."""

    outline: Annotated[list[tuple[Around, Around]], msgspec.Meta(min_length=3)]
    colour: Colour
    rim: Colour | None = None
    rim_width: Width = 0.008
    soft: Width = 0.004  # width of the border
    over_fins: bool = False  # it goes on over the fins, under their rays


class SkinSpots(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Round spots strewn over the upper side of a body with wings, in body lengths."""

    colour: Colour
    radius: tuple[Positive, Positive]  # of the smallest and the largest
    spacing: Annotated[float, msgspec.Meta(ge=0.005, le=1)]
    rings: Share = 0.0  # share of the larger ones that are rings

    def __post_init__(self) -> None:
        """Refuse spots that run into one another."""
        if not self.radius[0] <= self.radius[1] <= 0.5 * self.spacing:
            raise ValueError("radius must name the smaller first, and at most half the spacing")


class FinSkin(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A fin: at its root it has the body's colour."""

    colour: Colour
    opacity: Share = 0.8  # at the edge
    rim: Colour | None = None
    rim_width: Width = 0.012  # body lengths; of paired fins the share of their length
    striped: bool = False  # the body's stripes go on over it
    spines: Count = 0  # stiff rays in front, between which the membrane is cut in ...
    soft_rays: Count = 16  # ... and soft ones behind them, which part in two


class Variation(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Variation between the fishes of a species."""

    hue: Share = 0.05  # relative change of a primary colour
    saturation: Share = 0.10
    brightness: Share = 0.08
    pattern: Annotated[float, msgspec.Meta(ge=0, le=0.05)] = 0.006  # how far it is displaced,
    # body lengths
    torn: Share = 0.12  # share with a nick in the dorsal fin


class CourtshipColours(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Colours of a courting male (Tu §5.3): colours near one change to another."""

    of: Colour
    to: Colour
    reach: Annotated[float, msgspec.Meta(gt=0, le=2)] = (
        0.35  # greatest distance of a colour from `of`, linear RGB
    )
    saturation: Annotated[float, msgspec.Meta(ge=0, le=3)] = 1.0  # of all colours, times as much
    brightness: Annotated[float, msgspec.Meta(ge=0, le=3)] = 1.0


class SkinPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The colours of a species, painted in the order of the fields."""

    sheet: Annotated[str, msgspec.Meta(pattern=r"^[^/\\]+\.png$")] | None = None  # a picture to
    # wear instead of what is painted, beside the file; once it is loaded, its whole path
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
    pupil: Share = 0.55  # its size, share of the eye
    mouth: tuple[Place, Place] = ((0.0, -0.01), (0.03, -0.0184))  # its tip and its corner
    clear_back: Share = 0.0  # transparency of the back
    blotches: Share = 0.5  # strength of the uneven colour
    variation: Variation = Variation()
    display: CourtshipColours | None = None

    def __post_init__(self) -> None:
        """Refuse a mouth that does not open forwards."""
        if self.mouth[0][0] >= self.mouth[1][0]:
            raise ValueError("the corner of the mouth must lie behind its tip")


class Species(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One species: its names, build, motion and looks.

    It moves either by muscles (three tables) or by its spine (one table).
    """

    name: str
    scientific_name: str
    kind: Literal["pacifist", "prey", "predator"]
    schooling: bool
    size_cm: tuple[BodyLength, BodyLength]  # smallest and largest adults
    body: BodyPlan | None = None
    swim: SwimPlan | None = None
    turn: TurnPlan | None = None
    spine: SpinePlan | None = None
    surface: SurfacePlan
    skin: SkinPlan

    def __post_init__(self) -> None:
        """Refuse two movers, or none, sizes out of order, and a body that no step can carry."""
        if not self.name:
            raise ValueError("`name` is empty, expected the common name")
        given = sum(table is not None for table in (self.body, self.swim, self.turn))
        if given != (3 if self.spine is None else 0):
            raise ValueError("expected the tables [body], [swim] and [turn], or [spine] alone")
        if self.spine and self.spine.wings and not self.surface.wing:
            raise ValueError("[spine.wings] needs the outline [surface.wing]")
        if self.skin.spots and not self.surface.wing:
            raise ValueError("[skin.spots] are for bodies with [surface.wing]")
        if self.size_cm[0] > self.size_cm[1]:
            raise ValueError("size_cm must name the smallest length first")
        fins = {
            "dorsal": "dorsal",
            "ventral": "ventral",
            "pectoral": "paddles",
            "pelvic": "paddles",
        }
        for fin, colours in fins.items():
            if getattr(self.surface, fin) and not getattr(self.skin, colours):
                raise ValueError(f"the {fin} fin has no colours: [skin.{colours}] is missing")
        if self.body:
            check_step(self.body)

    @property
    def muscles(self) -> Muscles | None:
        """Body, swim and turn of a species that muscles move; None of one that its spine moves."""
        if self.body and self.swim and self.turn:
            return Muscles(self.body, self.swim, self.turn)
        return None

    @property
    def length_cm(self) -> float:
        """Body length of the fish that is recorded."""
        mover = self.body or self.spine
        assert mover  # one of the two is there
        return mover.length


def shipped_species() -> list[str]:
    """The species that come with the program, sorted."""
    return resource_names(SHIPPED, ".toml")


def own_species() -> Path:
    """The folder of the visitor's own species, which need not be there yet."""
    return own_path("species")


def species_names() -> list[str]:
    """Names that `load_species` knows: those that are shipped, then the visitor's own, sorted.

    Files are not read: one that is damaged has its name here.
    """
    shipped = shipped_species()
    return shipped + [name for name in stems(own_species(), ".toml") if name not in shipped]


def hidden_names() -> list[str]:
    """Return names of own files that are hidden by shipped species of the same name."""
    return sorted(set(stems(own_species(), ".toml")).intersection(shipped_species()))


def is_shipped(name: str) -> bool:
    """Whether the species called `name` comes with the program."""
    return name in shipped_species()


def species_file(name: str) -> Path:
    """The file of the species called `name`, or the file `name`; an unknown name is a UserError.

    A word without a slash or the ending ``.toml`` is a name.
    """
    if is_path(name, ".toml"):
        return Path(name)
    _check_known(name)
    return (resource_path(SHIPPED) if is_shipped(name) else own_species()) / f"{name}.toml"


def own_species_file(name: str) -> Path:
    """Return the path of the user's species `name`, which need not exist.

    A name that a shipped species has, or that no file can have, is a UserError.
    """
    if is_shipped(name):
        raise UserError(f"the name {name!r} is that of a shipped species, expected another")
    if not re.fullmatch(r"\w[\w-]*", name):
        raise UserError(f"the name {name!r}: expected letters, digits, _ and - alone")
    return own_species() / f"{name}.toml"


def repertoire_folder(name: str) -> Path:
    """Return the repertoire folder of the species `name`, which need not exist."""
    return resource_path("repertoires") if is_shipped(name) else own_path("repertoires")


def repertoire_file(name: str) -> Path:
    """The repertoire of the species called `name`, or the file `name`; there or not.

    A word without a slash or the ending ``.h5`` is a name; an unknown one is a UserError.
    """
    if is_path(name, ".h5"):
        return Path(name)
    _check_known(name)
    return repertoire_folder(name) / f"{name}.h5"


def muscular_names() -> list[str]:
    """Those of the shipped species that muscles move: they alone can be simulated."""
    return [name for name in shipped_species() if load_species(name).muscles]


def load_species(name: str) -> Species:
    """The species `name`; an unknown name or a faulty file is a UserError in one line."""
    path = species_file(name)
    return beside(path, load_toml(path, Species))


def beside(path: Path, species: Species) -> Species:
    """A species as the file `path` says it, with the whole path of its sheet."""
    if not (name := species.skin.sheet):
        return species
    sheet = str(path.absolute().with_name(name))
    return structs.replace(species, skin=structs.replace(species.skin, sheet=sheet))


def _check_known(name: str) -> None:
    if name not in (known := species_names()):
        raise unknown("species", name, known)
