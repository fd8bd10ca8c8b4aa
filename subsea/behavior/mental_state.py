"""Update hunger, libido and fear (Tu §7.4).

Set the initial sexes, habits and mental states of shoals and of individual fishes.
"""

from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Ints
from subsea.behavior.curious import SHY_S
from subsea.behavior.death import forget
from subsea.behavior.threat_memory import felt_fear, grow_used
from subsea.fish.character import draw_character
from subsea.fish.species import Species
from subsea.kernels import kernel
from subsea.scenario.schema import IndividualTable, Shoal
from subsea.state import (
    CURIOUS,
    FEAR,
    HUNGER,
    KINDS,
    LIBIDO,
    NO_COURTSHIP,
    NOBODY,
    PACIFIST,
    PREDATOR,
    PREY,
    WANDER,
    Clock,
    Fishes,
    Minds,
    Nature,
    Sea,
)
from subsea.state.feelings import fade_feelings

# Tu's p0 = 0.00067 and p1 = 0.0025 per time unit of 0.1 s.
DIGESTION = 0.0067  # 1/s: a meal is digested after 149 s
LIBIDO_RATE = 0.025  # 1/s: libido is full 40 s after a mating
DREAD_CM = 200.0  # D0
SEAS_OWN = -1.0  # dusk and mild of a fish to which the constants of all fishes apply
FOOD_STIMULUS = (0.05, 0.2)  # q1, q2 in 1/cm: food tempts from 20 cm, fully at 5 cm
MATE_STIMULUS = (0.025, 0.1)
DUSK = (16.0, 16.5, 19.0, 20.0)  # hours at which courtship begins, is full, fades and is over


@kernel
def update_mental_state(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock
) -> None:
    """Update `minds.mental` of the fishes `who` from what they perceive and remember.

    Only prey fear, and only pacifists court (Tu §7.9). Libido is full about dusk, except where a
    direction or a visitor has set it, or betrothed a pair. Digested meals are forgotten. Fear set
    by a direction replaces that of what is seen.
    """
    now = clock.tick * clock.dt
    fade_feelings(who, minds)
    season = ardour(sea.sky[0], nature.day_libido)
    for i in who:
        left = 1.0 - minds.digestion[i] * (now - minds.last_meal[i])
        if left <= 0.0:
            minds.eaten[i] = 0.0
        urge = 1.0 - minds.eaten[i] * left / minds.appetite[i]
        food = nature.hunger_stimulus * stimulus(minds.food_distance[i], *FOOD_STIMULUS)
        hunger = min(max(urge + food, 0.0), 1.0)
        minds.mental[i, HUNGER] = hunger
        minds.mental[i, LIBIDO] = 0.0
        if minds.kind[i] == PACIFIST:
            urge = minds.libido_rate[i] * (now - minds.last_mating[i]) * (1.0 - hunger)
            mate = nature.libido_stimulus * stimulus(minds.mate_distance[i], *MATE_STIMULUS)
            share = 1.0 if minds.ardent[i] or minds.betrothed[i] >= 0 else season
            minds.mental[i, LIBIDO] = share * min(max(urge + mate, 0.0), 1.0)
        if minds.kind[i] != PREY:
            minds.mental[i, FEAR] = 0.0
            continue
        grow_used(fishes, minds, i, sea, nature)
        fear = felt_fear(fishes, minds, i, sea, nature)
        minds.mental[i, FEAR] = min(minds.fright[i] if minds.fright[i] >= 0.0 else fear, 1.0)


@kernel
def ardour(hour: float, by_day: float) -> float:
    """Compute the share of libido at an hour: 1 about dusk, else `by_day`.

    Reef fishes that release eggs into open water spawn at dusk (Thresher 1984).
    """
    begins, full, fades, ends = DUSK
    share = min(max((hour - begins) / (full - begins), 0.0), 1.0)
    share *= min(max((ends - hour) / (ends - fades), 0.0), 1.0)
    return by_day + (1.0 - by_day) * share


@kernel
def stimulus(distance: float, low: float, high: float) -> float:
    """S of a thing at `distance` cm: 0 while 1/distance is below `low`, 1 above `high` (1/cm)."""
    strength = 1.0 / max(distance, 1e-6)
    if strength <= low:
        return 0.0
    if strength >= high:
        return 1.0
    return (strength - low) / (2.0 * high - low - strength)


PLANKTON_CM, PREY_CM = 8.0, 50.0  # body length per meal of the appetite
DONE_CHEWING_S = 6.0  # after a meal: see `hunting.CHEW_S`
HABITS = ("brightness", "darkness", "cold", "warmth")  # columns of `minds.likes`


TRAITS_OF_CHARACTER = ("timidity", "devotion", "activity", "sociability")


def character_of(
    shoal: Shoal, species: Species, seed: int, first: int, number: int
) -> dict[str, NDArray[np.float32]]:
    """Draw the traits (number,) of the fishes of a shoal from `first` on, by name."""
    keys = msgspec.structs.asdict(species.character)
    given = {key: getattr(shoal, key) for key in keys if getattr(shoal, key) is not None}
    plan = msgspec.structs.replace(species.character, **given)
    return draw_character(plan, seed, first, number)


def set_character(minds: Minds, these: slice, traits: dict[str, NDArray[np.float32]]) -> None:
    """Set the character of the fishes of a shoal; before their temperament, which depends on it."""
    for name in TRAITS_OF_CHARACTER:
        getattr(minds, name)[these] = traits[name]
    minds.voracity[these] = traits["appetite"]
    minds.fatigue[CURIOUS, these] = SHY_S * np.maximum(traits["timidity"] - 1.0, 0.0)


def set_temperament(
    shoal: Shoal, fishes: Fishes, minds: Minds, these: slice, rng: np.random.Generator
) -> None:
    """Set sexes, habits and initial mental states of the fishes of a shoal."""
    number = these.stop - these.start
    minds.male[these] = males_of(shoal, number)
    minds.likes[these] = [name in shoal.likes for name in HABITS]
    _set_appetite(fishes, minds, these)
    minds.digestion[these] = DIGESTION if shoal.digestion is None else shoal.digestion
    minds.libido_rate[these] = LIBIDO_RATE if shoal.libido_rate is None else shoal.libido_rate
    minds.dread[these] = DREAD_CM if shoal.dread_cm is None else shoal.dread_cm
    minds.dusk[these] = SEAS_OWN if shoal.dusk is None else shoal.dusk
    minds.mild[these] = SEAS_OWN if shoal.mild is None else shoal.mild
    hunger = rng.uniform(0, 0.6, number) if shoal.hunger is None else shoal.hunger
    libido = rng.uniform(0, 0.3, number) if shoal.libido is None else shoal.libido
    minds.eaten[these] = (1.0 - hunger) * minds.appetite[these]
    set_libido(minds, these, hunger, libido, 0.0)


def apply_individual(fishes: Fishes, minds: Minds, table: IndividualTable, now_s: float) -> None:
    """Apply the settings of an individual fish at `now_s`, the time of its hunger and libido.

    A change of kind or sex clears what the fish and others know of each other.
    """
    i = table.fish
    kind = minds.kind[i] if table.kind is None else KINDS.index(table.kind)
    male = minds.male[i] if table.male is None else table.male
    hunger = urge_to_eat(minds, i, now_s) if table.hunger is None else table.hunger
    if kind != minds.kind[i] or male != minds.male[i]:
        _forget_all(minds, i)
        minds.kind[i], minds.male[i] = kind, male
        _set_appetite(fishes, minds, i)
    if table.likes is not None:
        minds.likes[i] = [name in table.likes for name in HABITS]
    for name, value in (
        ("schools", table.schooling), ("digestion", table.digestion),
        ("libido_rate", table.libido_rate), ("dread", table.dread_cm), ("appetite", table.appetite),
        *((name, getattr(table, name)) for name in TRAITS_OF_CHARACTER),
        ("dusk", table.dusk), ("mild", table.mild),
    ):  # fmt: skip
        if value is not None:
            getattr(minds, name)[i] = value
    if hunger != urge_to_eat(minds, i, now_s):
        minds.eaten[i], minds.last_meal[i] = (1.0 - hunger) * minds.appetite[i], now_s
    if table.libido is not None:
        set_libido(minds, i, hunger, table.libido, now_s)
        minds.ardent[i] = True


def males_of(shoal: Shoal, number: int) -> NDArray[np.bool_]:
    """Select the males of a shoal, spread evenly so that a shoal of two is a pair."""
    males = np.floor(np.arange(1, number + 1) * shoal.male_share + 1e-9)
    return np.asarray(np.diff(males, prepend=0.0) > 0)


def appetite_of(length: Any, kind: Any) -> Any:
    """Return the default number of meals that fill fishes of some lengths, cm, and kinds."""
    meal_cm = np.where(kind == PREDATOR, PREY_CM, PLANKTON_CM)
    return np.maximum(np.round(length / meal_cm), 2.0)


def _set_appetite(fishes: Fishes, minds: Minds, these: slice | int) -> None:
    usual = appetite_of(fishes.length[these], minds.kind[these])
    minds.appetite[these] = np.float32(usual) * minds.voracity[these]


def urge_to_eat(minds: Minds, these: Any, now_s: float) -> Any:
    """Compute the hunger of fishes without the stimulus of food in sight (Tu §7.4)."""
    left = np.maximum(1.0 - minds.digestion[these] * (now_s - minds.last_meal[these]), 0.0)
    return 1.0 - minds.eaten[these] * left / minds.appetite[these]


def urge_to_mate(minds: Minds, these: Any, now_s: float) -> Any:
    """Compute the libido of sated fishes without the stimulus of a mate in sight."""
    since = now_s - minds.last_mating[these]
    return np.clip(minds.libido_rate[these] * since, 0.0, 1.0)


def set_hunger(minds: Minds, these: Any, hunger: Any, now_s: float) -> None:
    """Set the hunger of fishes by time and size of their last meal; none of them chews."""
    minds.last_meal[these] = now_s - DONE_CHEWING_S
    left = np.maximum(1.0 - minds.digestion[these] * DONE_CHEWING_S, 0.05)
    minds.eaten[these] = (1.0 - hunger) * minds.appetite[these] / left


def set_libido(minds: Minds, these: Any, hunger: Any, libido: Any, now_s: float) -> None:
    """Set the libido of fishes with a given `hunger` by the time of their last mating."""
    share = libido / np.maximum(1.0 - hunger, 0.1)
    minds.last_mating[these] = now_s - share / np.maximum(minds.libido_rate[these], 1e-9)


def _forget_all(minds: Minds, i: int) -> None:
    """Clear what fish i and others know of each other: indices depend on its kind."""
    forget(minds, i)
    for name in ("target", "memory", "memory_target", "food"):
        getattr(minds, name)[i] = -1
    for name in ("predator", "predators", "mate", "mates", "partner"):
        getattr(minds, name)[i] = NOBODY
    minds.foods[i] = -1
    minds.food_distance[i] = minds.mate_distance[i] = np.inf
    minds.intention[i], minds.courtship[i] = WANDER, NO_COURTSHIP
    for name in ("busy", "menace", "menaces", "courtship_time", "courtship_count", "alone"):
        getattr(minds, name)[i] = 0.0
    minds.unseen[i] = np.inf
    minds.inspection[i], minds.hull_dread[i] = 0.0, 1.0
    minds.resumed[i] = False
