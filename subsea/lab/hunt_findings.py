"""Hunts of a sea beside wanted ranges: rushes at close range, and the room between hunters."""

from collections.abc import Iterator, Sequence

from subsea.base.findings import RangeCheck
from subsea.fish.measured import PredationFacts, published
from subsea.lab.hunting import Hunts
from subsea.lab.measures import PERIOD_S

AIM = "project_aims"
TOUCHING_CM = 0.0  # least gap between the bodies of two hunters


def joined(parts: Sequence[Hunts]) -> Hunts:
    """Join the hunts of a dive that was recorded in parts, one after another."""
    seconds = sum(part.seconds for part in parts)
    rushes = sorted((one for part in parts for one in part.rushes), key=lambda one: one.start_s)
    return parts[-1]._replace(
        seconds=seconds,
        stalks=[one for part in parts for one in part.stalks],
        rushes=rushes,
        caught_s=[second for part in parts for second in part.caught_s],
        least_gap_cm=min(part.least_gap_cm for part in parts),
    )


def close_rushes(found: Hunts) -> tuple[float, float]:
    """Count the rushes at close range in the first `PERIOD_S`, and find the start of the first, s.

    A shorter run is scaled. The first is as late as the end of a run without any.
    """
    starts = [one.start_s for one in found.rushes if one.close and one.start_s < PERIOD_S]
    scale = max(PERIOD_S / found.seconds, 1.0)
    return scale * len(starts), min(starts, default=found.seconds)


def hunt_findings(
    label: str, runs: Sequence[Hunts], facts: PredationFacts, wanted: bool
) -> Iterator[RangeCheck]:
    """Compare the hunts in runs of one scenario with the aims, or only list them."""
    counts, firsts = zip(*(close_rushes(run) for run in runs), strict=True)
    number, first = "rushes at close range in 3 min, fewest", "first rush at close range, latest"
    note = f"{len(runs)} runs"
    if wanted:
        yield published(label, number, min(counts), "", facts.rushes, note)
        yield published(label, first, max(firsts), " s", facts.first)
    else:
        yield RangeCheck(label, number, min(counts), note=note)
        yield RangeCheck(label, first, max(firsts), " s")
    hidden = [one.hidden for run in runs for one in run.rushes if one.close]
    if hidden:
        share, note = sum(hidden) / len(hidden), f"{len(hidden)} rushes"
        yield RangeCheck(label, "rushes from the blind angle or from below", share, note=note)
    gap = min(run.least_gap_cm for run in runs)
    if gap < float("inf"):
        yield RangeCheck(
            label, "least gap between two hunters", gap, " cm", TOUCHING_CM, source=AIM
        )
