"""Hypothesis strategies for valid directions of a scenario."""

from hypothesis import strategies as st

from subsea.scenario.directions import Camera, Direction, FishSelector
from subsea.scenario.shoals import Shoals, numbers_of

HABITS = ["brightness", "darkness", "cold", "warmth"]
SHARE, SECONDS = st.floats(0.0, 1.0), st.floats(0.0, 20.0)


@st.composite
def directions(draw, shoals: Shoals, tours: list[str], hook: bool, places, most: int = 4):
    """Up to `most` directions for these shoals, at places drawn from `places`."""
    made = []
    for k in range(draw(st.integers(0, most))):
        when = {"at_s": draw(st.none() | SECONDS), "once": draw(st.booleans())}
        if earlier := [one.name for one in made if one.name]:
            when["after"] = draw(st.none() | st.sampled_from(earlier))
            when["delay_s"] = draw(SECONDS) if when["after"] else 0.0
        when["event"] = draw(
            st.sampled_from([None, "courting", "spawned", "eaten", "caught", "sated", "fleeing",
                             "hunting", "passes"])
        )  # fmt: skip
        if when["event"] == "passes":
            when |= {"gate_cm": draw(places), "radius_cm": draw(st.floats(1.0, 2000.0))}
        when["every_s"] = draw(st.none() | st.floats(0.1, 10.0))
        when["fewer_than"] = draw(st.none() | st.integers(1, 100))
        if when["event"] or when["fewer_than"]:
            when["of"] = draw(st.none() | whose(shoals))
        what = draw(influences(shoals, tours, hook, places))
        about = when["event"] or when.get("after") or "pair" in what
        if "camera" in what and what["camera"].follow == "cast" and not about:
            what["camera"] = Camera(follow=draw(whose(shoals)))
        name = draw(st.sampled_from(["", f"number {k}"])) if what else f"number {k}"
        made.append(Direction(name=name, **when, **what))
    return made


def whose(shoals: Shoals):
    """A selection of fishes."""
    kinds = [st.builds(FishSelector, shoal=st.integers(0, len(shoals.species) - 1)),
             st.builds(FishSelector, species=st.sampled_from([*shoals.species]))]  # fmt: skip
    if shoals.kind:
        kinds.append(st.builds(FishSelector, fish=st.integers(0, len(shoals.kind) - 1)))
    return st.one_of(kinds)


@st.composite
def influences(draw, shoals: Shoals, tours: list[str], hook: bool, places):
    """The effects of a direction, by key."""
    what = {}
    who = draw(st.none() | whose(shoals))
    if who is not None:
        kinds = {shoals.kind[i] for i in numbers_of(who, shoals)}
        kinds = kinds or {"pacifist", "prey", "predator"}
        moves = {
            "path_cm": st.lists(places, min_size=1, max_size=3), "hunger": SHARE,
            "likes": st.lists(st.sampled_from(HABITS), max_size=2),
        }  # fmt: skip
        if "pacifist" in kinds:
            moves["libido"] = SHARE
        if "prey" in kinds:
            moves["fear"] = SHARE
        if "predator" in kinds:
            moves |= {"hunts": st.just("any") | whose(shoals), "rests": st.just(True)}
        chosen = draw(st.sets(st.sampled_from([*moves]), min_size=1, max_size=2))
        if chosen >= {"hunts", "rests"}:
            chosen.discard("rests")
        what = {"who": who, **{name: draw(moves[name]) for name in sorted(chosen)}}
        if "path_cm" in chosen:
            what["loop"] = draw(st.booleans())
            what["speed_cm_s"] = draw(st.none() | st.floats(1.0, 100.0))
    mild = [i for i, kind in enumerate(shoals.kind) if kind == "pacifist"]
    if len(mild) > 1 and "path_cm" not in what and draw(st.booleans()):
        pair = draw(st.lists(st.sampled_from(mild), min_size=2, max_size=2, unique=True))
        what |= {"pair": tuple(pair), "place_cm": draw(st.none() | places)}
    others = {
        "current_cm_s": st.tuples(st.floats(-30.0, 30.0), st.floats(-30.0, 30.0)),
        "lights": st.booleans(), "end": st.just(True),
        "caption": st.sampled_from(["They court.", 'A "shark"', "\\ # ünd"]),
        "camera": st.builds(Camera, follow=st.just("cast") | whose(shoals),
                            position_cm=st.none() | places),
    }  # fmt: skip
    if hook:
        others["hook"] = st.sampled_from(["down", "up"])
    if tours:
        others["camera"] |= st.builds(Camera, tour=st.sampled_from(tours))
    chosen = draw(st.sets(st.sampled_from(sorted(others)), max_size=2))
    what |= {name: draw(others[name]) for name in sorted(chosen)}
    return what | {"over_s": draw(SECONDS), "for_s": draw(st.none() | SECONDS)} if what else what
