"""The measures of a record as a table in text."""

from typing import Any

from subsea.base.progress import count_noun

Measured = dict[str, Any]


def table(found: Measured) -> list[str]:
    """Format measures as lines of text."""
    sea, minds, food = found["sea"], found["minds"], found["food"]
    species = ", ".join(f"{number} {name}" for name, number in found["species"].items())
    lines = [
        f"{count_noun(found['ticks'], 'tick', 'ticks')} ({found['seconds']:g} s) of "
        f"{count_noun(found['fishes'], 'fish', 'fishes')}, seed {found['seed']}: {species}",
        "",
        _line("out of bounds or in an obstacle", f"{sea['out_of_bounds_or_inside']:,} of "
              f"{sea['fish_ticks']:,} fish-ticks"),
        _line("least clearance", _cm(sea)),
        _line("bodies overlap", f"{sea['overlap_share']:.3%} of fish-ticks, and "
              f"{sea['meant_overlap_share']:.3%} intended (courting, hunting)"),
        _line("changes of intention", f"{minds['changes_per_second']:.2f} a second and fish, "
              f"at most {minds['changes_per_second_most']:.2f}"),
        _line("hunger saturated", f"{minds['hunger_saturated_share']:.2%} of fish-ticks"),
        _line("plankton", f"{food['plankton_start']} specks, at least {food['plankton_least']}, "
              f"{food['plankton_end']} in the end; {food['meals']} meals"),
        _line("escapes", _escapes(minds)),
        *_caught(found["captures"]),
        *_mated(found["mating"]),
        "",
        *_budget(minds["time_budget"], food["meals_per_fish_minute"]),
    ]  # fmt: skip
    return lines + _schools(found["schools"])


def _line(name: str, value: str) -> str:
    return f"{name:32s} {value}"


def _cm(sea: Measured) -> str:
    if sea["least_clearance_cm"] is None:
        return "nobody lives"
    return f"{sea['least_clearance_cm']:.1f} cm from the {sea['least_clearance_from']}"


def _escapes(minds: Measured) -> str:
    if not minds["escapes"]:
        return "none"
    after = f"{minds['escapes_after_fear_share']:.1%} with alarming fear before they begin"
    return f"{minds['escapes']}, {after}"


def _caught(captures: Measured) -> list[str]:
    if not captures["lost"]:
        return [_line("eaten or landed", "nobody")]
    parts = []
    for name in ("prey_in_company", "prey_alone"):
        rate = captures[name]["caught_per_1000_fish_s"]
        words = name.replace("_", " ")
        parts.append(
            f"{words} {captures[name]['caught']}"
            + (f" ({rate:.2f} in 1000 fish-seconds)" if rate is not None else "")
        )
    return [_line("eaten or landed", f"{captures['lost']}: " + ", ".join(parts))]


def _mated(mating: Measured) -> list[str]:
    if not mating["courtships"]:
        return [_line("courtships", "none")]
    lines = [
        _line(
            "courtships",
            f"{mating['courtships']}, {mating['complete']} complete, "
            f"{mating['rejected']} rejected ({mating['rejected_and_turned_away']} turned away)",
        )
    ]
    for one in mating["each"][:12]:
        partner = one["partner"] if one["partner"] >= 0 else "nobody"
        lines.append(
            _line("", f"{one['start_s']:6.1f} s  {one['male']} with {partner}: "
                  + " → ".join(one["states"]))
        )  # fmt: skip
    return lines


def _budget(budget: Measured, meals: Measured) -> list[str]:
    intentions = list(next(iter(budget.values())))
    head = f"{'time budget':26s}" + "".join(f"{name:>9s}" for name in intentions)
    lines = [head + "   meals a minute"]
    for name, row in budget.items():
        shares = "".join(f"{row[intention]:9.1%}" for intention in intentions)
        lines.append(f"{name:26s}{shares}{meals[name]:17.2f}")
    return lines


def _schools(schools: list[Measured]) -> list[str]:
    if not schools:
        return []
    lines = [
        "",
        "school of  fishes  cruises  polarisation (5%)  nearest neighbour, BL (5–95%)  splits  "
        "longest",
    ]
    for one in schools:
        near = one["nearest_bl"]
        values = (one["polarisation_median"], one["polarisation_p5"], *near.values())
        if None in values:
            middle = f"{'–':>19s}  {'–':>29s}"
        else:
            polarised = f"{values[0]:.2f} ({values[1]:.2f})"
            spaced = f"{values[3]:.2f} ({values[2]:.2f}–{values[4]:.2f})"
            middle = f"{polarised:>19s}  {spaced:>29s}"
        longest = f"{one['longest_split_s']:.1f} s" if one["splits"] else "–"
        if one["not_rejoined"]:
            longest += ", not rejoined"
        lines.append(
            f"{one['leader']:9d}{one['fishes']:8d}{one['cruising_share']:9.0%}{middle}"
            f"{one['splits']:8d}  {longest}"
        )
    return lines
