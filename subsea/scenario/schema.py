"""Tables of scenario files (see `assets/scenarios`), and Jerlov's optical water types."""

from typing import Annotated, Literal, NamedTuple

import msgspec

from subsea.fish.character import TRAIT_RANGE, Trait
from subsea.fish.species import BodyLength
from subsea.scenario.directions import MAX_DIRECTIONS, Coordinate, Direction, Flow, Habit
from subsea.scenario.school_rules import SchoolRules, SchoolTable, merged

WaterType = Literal["I", "IB", "II", "III", "1C", "3C", "5C", "9C"]
Rgb = tuple[float, float, float]

# Share of 650 nm in the red channel of a camera; the rest is at 550 nm, where water absorbs little.
RED_SHARE = 0.5
# Backscatter of the water itself at 650, 550 and 450 nm (wavelength to the power -4.3), over that
# at 450 nm.
MOLECULES: Rgb = (0.206, 0.422, 1.0)
FAR_LUMINANCE, FAR_MOST = 0.072, 0.185  # of distant water, seen level: mean, and largest channel
LUMINANCE: Rgb = (0.2126, 0.7152, 0.0722)


class Jerlov(NamedTuple):
    """One type."""

    kd: Rgb  # diffuse attenuation, 1/m, at 650, 550 and 450 nm
    visibility_cm: float  # distance at which contrast falls to 2%, if a scenario does not say
    particles: float  # their backscatter over that of the water itself at 450 nm, in every colour


# Attenuation: I to 1C Austin and Petzold (1984), 3C to 9C Jerlov (1976).
JERLOV: dict[str, Jerlov] = {
    "I": Jerlov((0.356, 0.064, 0.018), 3200.0, 1.1),
    "IB": Jerlov((0.365, 0.072, 0.036), 2800.0, 0.9),
    "II": Jerlov((0.384, 0.086, 0.071), 2300.0, 0.6),
    "III": Jerlov((0.418, 0.114, 0.138), 1800.0, 0.7),
    "1C": Jerlov((0.453, 0.142, 0.205), 1400.0, 1.5),
    "3C": Jerlov((0.46, 0.19, 0.39), 1000.0, 3.0),
    "5C": Jerlov((0.54, 0.30, 0.56), 650.0, 5.0),
    "9C": Jerlov((0.76, 0.63, 1.6), 330.0, 8.0),
}


def attenuation(name: str) -> Rgb:
    """Diffuse attenuation of red, green and blue light in a type of water, 1/cm."""
    red, green, blue = JERLOV[name].kd
    return 0.01 * (RED_SHARE * red + (1.0 - RED_SHARE) * green), 0.01 * green, 0.01 * blue


def far_colour(name: str) -> Rgb:
    """Linear colour of distant water of a type, seen level: what it scatters over what it takes."""
    one = JERLOV[name]
    sent = [(pure + one.particles) / k for pure, k in zip(MOLECULES, one.kd, strict=True)]
    bright = sum(share * x for share, x in zip(LUMINANCE, sent, strict=True))
    scale = min(FAR_LUMINANCE / bright, FAR_MOST / max(sent))
    return scale * sent[0], scale * sent[1], scale * sent[2]


MAX_FISHES = 100_000
# Each has two rows in a texture; OpenGL drivers limit its height to 16384 or less.
MAX_SIMULATED = 4000
MAX_SOLIDS = 200  # of pillars, and of rocks
MAX_CLUSTERS, MAX_LEAVES = 500, 40  # of seaweed in a group, of leaves in a cluster
MAX_VENTS = 50
MAX_GROWTHS = 2000  # in all reefs together
MAX_SEAWEED = 8000  # leaves in total; their nodes must fit into a texture
AUTOPILOT, DIRECTED = "auto", "directed"  # reserved names of tours
MAX_WAYPOINTS = 200  # of a tour
Positive = Annotated[float, msgspec.Meta(ge=0.001, le=1e5)]
MAX_SEED = 2**32 - 1
Seed = Annotated[int, msgspec.Meta(ge=0, le=MAX_SEED)]
Rate = Annotated[float, msgspec.Meta(ge=0, le=1)]
Size = Annotated[float, msgspec.Meta(ge=0.001, le=1000)]
TankSide = Annotated[float, msgspec.Meta(ge=150, le=4000)]
Period = Annotated[float, msgspec.Meta(ge=100, le=20000)]
Celsius = Annotated[float, msgspec.Meta(ge=-2, le=40)]
Share = Annotated[float, msgspec.Meta(ge=0, le=1)]
Colour = tuple[Share, Share, Share]
Factor = Annotated[float, msgspec.Meta(ge=0, le=100)]
Dread = Annotated[float, msgspec.Meta(ge=0, le=5000)]
TraitValue = Annotated[float, msgspec.Meta(ge=TRAIT_RANGE[0], le=TRAIT_RANGE[1])]
Kind = Literal["pacifist", "prey", "predator"]
SchoolKind = Literal["neighbours", "leader"]
Weight = Annotated[float, msgspec.Meta(ge=0, le=1000)]
GrowthKind = Literal[
    "staghorn", "bush", "table", "brain", "lettuce", "finger", "leather", "soft", "fan", "pipes",
    "barrel", "anemone", "rubble",
]  # fmt: skip


class Bounds(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The sea is a cylinder: from the seabed at about -depth_cm up to the surface at z = 0."""

    radius_cm: Annotated[float, msgspec.Meta(ge=300, le=20000)]
    depth_cm: Annotated[float, msgspec.Meta(ge=200, le=5000)]
    # Inner length along x and width along y of a tank with walls of glass around the middle.
    tank_cm: tuple[TankSide, TankSide] | None = None
    # Length along x and width along y of a box of open water around the middle, whose sides are
    # periodic: a fish that leaves on one side comes in on the other.
    periodic_cm: tuple[Period, Period] | None = None


class Water(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Appearance and motion of the water."""

    # Jerlov's optical type. `fog` and `visibility_cm` replace what follows from it; one of both
    # ways must say how the water looks.
    type: WaterType | None = None
    hour: Annotated[float, msgspec.Meta(ge=0, le=24)] = 12.0  # at the start; the sun is up 6 to 18
    # Length of a day in minutes of the dive; 0: the hour stays. Faster days would flash.
    day_minutes: Annotated[float, msgspec.Meta(ge=0, le=1440)] = 0.0
    fog: Colour | None = None  # linear RGB of the far water, seen level
    # Distance at which contrast falls to 2%; 0: that of the type.
    visibility_cm: Annotated[float, msgspec.Meta(ge=50, le=1e5)] = 0.0
    current_cm_s: tuple[Flow, Flow] = (0.0, 0.0)  # strength of the swell along x and y
    stream_cm_s: tuple[Flow, Flow] = (0.0, 0.0)  # steady current, which carries odours away
    plankton: Annotated[int, msgspec.Meta(ge=0, le=100000)] = 0
    temperature_c: tuple[Celsius, Celsius] = (27.0, 21.0)  # at the surface and at `depth_cm`
    light_depth_cm: Positive = 700.0  # depth at which light falls to 1/e

    def __post_init__(self) -> None:
        """Take the visibility from the type; refuse water of unknown look, and days that flash."""
        if 0.0 < self.day_minutes < 1.0:
            raise ValueError("`day_minutes` must be 0, which stops the clock, or at least 1")
        if self.type is None and (self.fog is None or not self.visibility_cm):
            missing = "fog" if self.fog is None else "visibility_cm"
            raise ValueError(f'expected `{missing}`, or a `type` of water such as "II"')
        if self.type is not None and not self.visibility_cm:
            msgspec.structs.force_setattr(self, "visibility_cm", JERLOV[self.type].visibility_cm)

    @property
    def far(self) -> Colour:
        """Colour of the far water: `fog`, or that of the type."""
        return far_colour(self.type or "II") if self.fog is None else self.fog


class Grade(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The finish of the picture, as a photographer develops it."""

    exposure_ev: Annotated[float, msgspec.Meta(ge=-3, le=3)] = 0.0  # stops brighter
    contrast: Annotated[float, msgspec.Meta(ge=0.5, le=2)] = 1.0  # power about a middle grey
    saturation: Annotated[float, msgspec.Meta(ge=0, le=2)] = 1.0  # 0: grey
    warmth: Annotated[float, msgspec.Meta(ge=-1, le=1)] = 0.0  # toward amber, below 0 toward blue


UNGRADED = Grade()


class Terrain(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The height field of the seabed."""

    dune_height_cm: Annotated[float, msgspec.Meta(ge=0, le=400)]
    dune_length_cm: Annotated[float, msgspec.Meta(ge=50, le=1e5)]
    seed: Seed = 0
    # A shelf beyond a slope: its height, how wide the slope is, in which direction it lies, and how
    # far from the middle of the sea the middle of the slope is.
    shelf_cm: Annotated[float, msgspec.Meta(ge=0, le=2500)] = 0.0
    slope_cm: Annotated[float, msgspec.Meta(ge=50, le=1e5)] = 400.0
    shelf_deg: Coordinate = 0.0
    shelf_at_cm: Coordinate = 0.0


class Shoal(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Fishes of one species that start together."""

    species: str
    number: Annotated[int, msgspec.Meta(ge=0, le=MAX_FISHES)]
    size_cm: tuple[BodyLength, BodyLength] | None = None  # smallest and largest; None: the species'
    position_cm: tuple[Coordinate, Coordinate, Coordinate] | None = (
        None  # centre; None: spread over the sea
    )
    spread_cm: Positive = 150.0
    heading_deg: Coordinate | None = None  # None: random
    toward_cm: tuple[Coordinate, Coordinate, Coordinate] | None = None  # their first goal
    leader_cm: BodyLength | None = None  # of the first fish, the leader; None: like the others
    school: SchoolKind | None = None  # None: "leader" with `leader_cm`, else "neighbours"
    kind: Kind | None = None  # None: the species'
    male_share: Share = 0.5
    likes: list[Habit] = []  # Tu §7.3
    schooling: bool | None = None  # None: the species'
    rules: SchoolRules = SchoolRules()  # of its schools, where they differ from `[school]`
    hunger: Share | None = None  # initial internal urge; None: random
    libido: Share | None = None
    digestion: Rate | None = None  # p0 of Tu §7.4, 1/s
    libido_rate: Rate | None = None  # p1, 1/s
    dread_cm: Dread | None = None  # D0
    # Mean and spread of the traits of its fishes; None: the species'.
    timidity: Trait | None = None
    devotion: Trait | None = None
    activity: Trait | None = None
    sociability: Trait | None = None
    appetite: Trait | None = None  # over the usual number of meals
    dusk: Share | None = None  # None: that of all fishes, as for the next
    mild: Share | None = None

    @property
    def is_led(self) -> bool:
        """True if schools of the shoal follow a leader (Tu §7.9.2)."""
        return self.school == "leader" or (self.school is None and self.leader_cm is not None)


class Pillar(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A round pillar that stands on the seabed."""

    position_cm: tuple[Coordinate, Coordinate]
    radius_cm: Annotated[float, msgspec.Meta(ge=0.001, le=1000)]
    height_cm: Annotated[float, msgspec.Meta(ge=0.001, le=5000)]  # above the seabed at its middle


class Rock(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A boulder: an ellipsoid with the share `sunk` of its height below the seabed."""

    position_cm: tuple[Coordinate, Coordinate]
    size_cm: tuple[Size, Size, Size]  # half axes
    yaw_deg: Coordinate = 0.0
    sunk: Share = 0.3
    height_cm: Coordinate | None = None  # of its centre above the seabed, instead of `sunk`


class Outcrop(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A knoll of overlapping rocks; the same seed gives the same rocks."""

    position_cm: tuple[Coordinate, Coordinate]
    size_cm: tuple[Size, Size, Size]  # half length, half width, height above the seabed
    rocks: Annotated[int, msgspec.Meta(ge=1, le=MAX_SOLIDS)] = 6
    yaw_deg: Coordinate = 0.0
    seed: Seed = 0


class Arch(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """An arch of rocks: two legs and a bow, for the submarine and schools to swim through."""

    position_cm: tuple[Coordinate, Coordinate]  # of the middle between the legs
    # The opening; fits the hull with its safety distance on both sides.
    span_cm: Annotated[float, msgspec.Meta(ge=220, le=3000)]
    height_cm: Annotated[float, msgspec.Meta(ge=160, le=3000)]
    thickness_cm: Annotated[float, msgspec.Meta(ge=30, le=600)] = 90.0
    yaw_deg: Coordinate = 0.0  # of the line from leg to leg; 90 opens it along x
    seed: Seed = 0


class Ridge(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A long, winding ridge of overlapping rocks: a spur of a reef, or a wall."""

    position_cm: tuple[Coordinate, Coordinate]  # of its middle
    length_cm: Annotated[float, msgspec.Meta(ge=100, le=10000)]
    width_cm: Annotated[float, msgspec.Meta(ge=40, le=1000)]  # at the foot
    height_cm: Annotated[float, msgspec.Meta(ge=20, le=1000)]  # above the seabed, at its highest
    yaw_deg: Coordinate = 0.0  # of its length
    seed: Seed = 0


class Wreck(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A sunken ship, upright on its keel and overgrown: broken sides, a deck, a mast."""

    position_cm: tuple[Coordinate, Coordinate]  # of its middle
    length_cm: Annotated[float, msgspec.Meta(ge=600, le=6000)] = 1200.0  # from stern to bow
    width_cm: Annotated[float, msgspec.Meta(ge=180, le=1500)] = 360.0
    height_cm: Annotated[float, msgspec.Meta(ge=100, le=1000)] = 240.0  # of its sides
    mast_cm: Annotated[float, msgspec.Meta(ge=0, le=3000)] = 0.0  # top over the seabed; 0: no mast
    broken: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.35  # share of the sides that is gone
    yaw_deg: Coordinate = 0.0  # of the way that its bow points
    seed: Seed = 0


class Hook(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A baited hook that descends on a line (Tu §10.1)."""

    position_cm: tuple[Coordinate, Coordinate]
    depth_cm: Annotated[float, msgspec.Meta(ge=0.001, le=5000)]  # how deep it hangs
    speed_cm_s: Annotated[float, msgspec.Meta(ge=0.001, le=200)] = (
        30.0  # down, and up with the catch
    )
    start_s: Annotated[float, msgspec.Meta(ge=0, le=1e6)] = 0.0

    @property
    def bait_cm(self) -> tuple[float, float, float]:
        """The final position of the bait."""
        return (*self.position_cm, -self.depth_cm)


class SeaweedTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Clusters of leaves rooted in the seabed or on a solid that stands there."""

    # Broad leaves, tall stipes with blades, short tufts, branched red algae; each along a chain.
    kind: Literal["ribbon", "kelp", "grass", "red"] = "ribbon"
    position_cm: tuple[Coordinate, Coordinate] | None = None  # None: scattered over the sea
    spread_cm: Positive = 120.0  # maximum distance of clusters from it
    clusters: Annotated[int, msgspec.Meta(ge=0, le=MAX_CLUSTERS)] = 1
    leaves: Annotated[int, msgspec.Meta(ge=1, le=MAX_LEAVES)] = 6  # of each cluster
    height_cm: Annotated[float, msgspec.Meta(ge=5, le=1000)] = 90.0
    width_cm: Annotated[float, msgspec.Meta(ge=0.001, le=100)] | None = (
        None  # None: by kind and height
    )
    colour: Colour | None = None  # linear RGB; None: the kind's


class Vent(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A place where air bubbles leave the seabed (Tu §8.2)."""

    position_cm: tuple[Coordinate, Coordinate]
    rate_per_s: Annotated[float, msgspec.Meta(ge=0.001, le=100)] = 12.0
    size_cm: Annotated[float, msgspec.Meta(ge=0.05, le=10)] = 1.2  # largest diameter


class ReefTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Corals, sponges and anemones on the sand and on solids that stand there."""

    position_cm: tuple[Coordinate, Coordinate] | None = None  # None: all over the sea
    spread_cm: Positive = 200.0  # maximum distance from it
    # Number if stone covers as much as the ground around; fewer if there is no room.
    number: Annotated[int, msgspec.Meta(ge=0, le=MAX_GROWTHS)] = 100
    kinds: dict[GrowthKind, Weight] = {}  # weights; empty: all kinds that suit the ground
    size: Annotated[float, msgspec.Meta(ge=0.3, le=3)] = 1.0  # factor on the usual sizes
    rock: Share = 0.65  # share on rocks and pillars, if there are any
    seed: Seed = 0

    def __post_init__(self) -> None:
        """Refuse weights that are all 0."""
        if self.kinds and not any(self.kinds.values()):
            raise ValueError("`kinds` must give a weight above 0 to one of them")


class CoralTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A single coral, sponge or anemone that stays where it is put, on the sand or on stone."""

    kind: GrowthKind
    position_cm: tuple[Coordinate, Coordinate]
    size_cm: Annotated[float, msgspec.Meta(ge=3, le=200)] = 25.0  # radius
    yaw_deg: Coordinate = 0.0
    seed: Seed = 0  # of its form and colours


class Start(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Initial state of the submarine."""

    position_cm: tuple[Coordinate, Coordinate, Coordinate]
    heading_deg: Coordinate = 0.0
    lights: bool = False  # on or off


class Waypoint(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A place on a tour and its target; without a target, as before and after it."""

    time_s: Annotated[float, msgspec.Meta(ge=0, le=3600)]
    position_cm: tuple[Coordinate, Coordinate, Coordinate]
    look_at_cm: tuple[Coordinate, Coordinate, Coordinate] | None = None
    follow: str | None = None  # a species
    ahead: bool = False  # along the path

    def __post_init__(self) -> None:
        """Refuse two targets at once."""
        if (self.look_at_cm is not None) + (self.follow is not None) + self.ahead > 1:
            raise ValueError("only one of `look_at_cm`, `follow` and `ahead` can be looked at")

    @property
    def looks(self) -> bool:
        """True if it has a target."""
        return self.ahead or self.look_at_cm is not None or self.follow is not None


class TourTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A path on which the submarine is carried for films."""

    name: Annotated[str, msgspec.Meta(min_length=1)]
    waypoint: Annotated[list[Waypoint], msgspec.Meta(min_length=2, max_length=MAX_WAYPOINTS)]
    loop: bool = False  # return from the last waypoint to the first and repeat


class NatureTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Constants of perception and behavior, as `state.Nature` explains them."""

    vision_cm: Positive = 500.0
    smell_cm: Positive = 600.0
    standard_cm: Positive = 20.0
    hunger_stimulus: Share = 0.8
    libido_stimulus: Share = 0.5
    alarmed: Share = 0.5
    panicked: Share = 0.8
    keen: Share = 0.25
    devotion_cm: Annotated[float, msgspec.Meta(ge=0, le=1e4)] = 25.0
    fatigue_s: Positive = 40.0
    fear_s: Positive = 15.0
    habituation_s: Positive = 60.0
    timidity: Annotated[float, msgspec.Meta(ge=0.1, le=5)] = 1.0
    submarine_cm: Annotated[float, msgspec.Meta(ge=0, le=5000)] = 80.0
    curiosity_cm: Annotated[float, msgspec.Meta(ge=0, le=5000)] = 350.0
    dusk: Share = 0.5
    mild: Share = 0.5
    day_libido: Share = 0.1
    calm_dread: Share = 0.5

    def __post_init__(self) -> None:
        """Refuse thresholds in the wrong order (Tu §7.5)."""
        if self.alarmed >= self.panicked:
            raise ValueError("`alarmed` must be less than `panicked`")
        if self.vision_cm > self.smell_cm:
            raise ValueError("`vision_cm` must not be more than `smell_cm`")


class IndividualTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Properties of one fish, which replace those of its shoal and random values."""

    fish: Annotated[
        int, msgspec.Meta(ge=0, lt=MAX_FISHES)
    ]  # its number from 0, counted through all shoals
    kind: Kind | None = None
    male: bool | None = None
    likes: list[Habit] | None = None  # Tu §7.3
    schooling: bool | None = None
    hunger: Share | None = None  # the internal urge
    libido: Share | None = None
    appetite: Annotated[float, msgspec.Meta(ge=1, le=1000)] | None = None  # meals that fill it
    digestion: Rate | None = None  # p0 of Tu §7.4, 1/s
    libido_rate: Rate | None = None  # p1, 1/s
    dread_cm: Dread | None = None  # D0
    timidity: TraitValue | None = None
    devotion: TraitValue | None = None
    activity: TraitValue | None = None
    sociability: TraitValue | None = None
    dusk: Share | None = None
    mild: Share | None = None


class PhysicsTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The physics of fishes that are simulated (Tu §9.2), as `state.Physics` explains it."""

    unit_mass: Annotated[float, msgspec.Meta(ge=0.1, le=10)] = 1.0
    viscosity: Factor = 1.0
    stiffness: Annotated[float, msgspec.Meta(ge=0.01, le=100)] = 1.0
    water_viscosity: Factor = 1.0
    hydrodynamics: bool = True
    time_step: Annotated[float, msgspec.Meta(ge=0.05, le=50)] = 1.0
    iterations: Annotated[int, msgspec.Meta(ge=1, le=60)] = 6
    fish: Annotated[int, msgspec.Meta(ge=-1, lt=MAX_FISHES)] = -1  # has priority for simulation


class Scenario(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The initial state of a dive."""

    title: str
    description: Annotated[str, msgspec.Meta(max_length=200)] = ""  # a sentence, for the menu
    seed: Seed
    bounds: Bounds
    water: Water
    grade: Grade = UNGRADED
    terrain: Terrain
    submarine: Start
    fish: Annotated[list[Shoal], msgspec.Meta(min_length=1)]
    pillar: Annotated[list[Pillar], msgspec.Meta(max_length=MAX_SOLIDS)] = []
    rock: Annotated[list[Rock], msgspec.Meta(max_length=MAX_SOLIDS)] = []
    outcrop: Annotated[list[Outcrop], msgspec.Meta(max_length=MAX_SOLIDS)] = []
    ridge: Annotated[list[Ridge], msgspec.Meta(max_length=MAX_SOLIDS)] = []
    arch: Annotated[list[Arch], msgspec.Meta(max_length=MAX_SOLIDS)] = []
    wreck: Annotated[list[Wreck], msgspec.Meta(max_length=MAX_SOLIDS)] = []
    hook: Hook | None = None
    seaweed: list[SeaweedTable] = []
    vent: Annotated[list[Vent], msgspec.Meta(max_length=MAX_VENTS)] = []
    reef: list[ReefTable] = []
    coral: Annotated[list[CoralTable], msgspec.Meta(max_length=MAX_GROWTHS)] = []
    tour: list[TourTable] = []
    direction: Annotated[list[Direction], msgspec.Meta(max_length=MAX_DIRECTIONS)] = []
    nature: NatureTable = NatureTable()
    school: SchoolTable = SchoolTable()  # rules of all schools
    individual: list[IndividualTable] = []
    physics: PhysicsTable = PhysicsTable()
    # Number of the nearest fishes that are simulated instead of played back.
    simulated: Annotated[int, msgspec.Meta(ge=0, le=MAX_SIMULATED)] = 0
    levels: bool = True  # False: in a dive, far fishes think no less often

    def rules_of(self, shoal: Shoal) -> SchoolRules:
        """Merge the rules of a shoal: of all schools, of its species, and its own."""
        of_species = self.school.species.get(shoal.species, SchoolRules())
        return merged([self.school, of_species, shoal.rules])

    @property
    def species(self) -> list[str]:
        """The species of the scenario, in the order of their numbers in the world."""
        return sorted({shoal.species for shoal in self.fish})
