"""Report the segments of a repertoire file and the measures of their motion."""

from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec

from capture.inspection.simulated import measure_simulated
from capture.inspection.spine_driven import measure_spine_driven
from capture.inspection.targets import Measure
from capture.recording.record import motion_from_provenance
from subsea.base.errors import UserError
from subsea.repertoire import BASIC_SEGMENTS, SEGMENTS, Repertoire, read_repertoire

HEADINGS = (
    "segment", "pattern", "grade", "frames", "cyclic", "cm/s", "L/s", "L/beat", "turn °",
    "loop error L", "radius L", "points",
)  # fmt: skip

SOURCES = {
    "biomechanics": "Measured by simulating again from the provenance",
    "spine": "Measured against the spine plan in the provenance",
}


def report(path: Path, write: Callable[[str], object]) -> bool:
    """Write the report on a file line by line; return whether every limit is kept.

    UserError where the file is damaged or not a repertoire.
    """
    repertoire = read_repertoire(path)
    missing = [name for name in BASIC_SEGMENTS if name not in repertoire.segments]
    write(
        f"{path}: {repertoire.species}, {repertoire.body_length_cm:g} cm, from "
        f"{repertoire.source}, a frame each {1000 * repertoire.tick_s:g} ms"
    )
    write("")
    for line in _table([HEADINGS, *_segment_rows(repertoire)]):
        write(line)
    write("")
    if repertoire.source not in SOURCES or missing:
        gap = f"no {', '.join(missing)}" if missing else f"its source is {repertoire.source!r}"
        write(f"Measures of the motion need a full repertoire of a known source; {gap}.")
        return not missing
    write(f"{SOURCES[repertoire.source]} (L: body length, tu: 0.1 s):")
    write("")
    write(_line("", "", "at least", "", "aim", ""))
    failed, missed = 0, 0
    for found in _measures(path, repertoire):
        failed += not found.passed
        missed += not found.aim_reached
        write(
            _line(
                found.name,
                found.value,
                found.limit,
                _verdict(found.limit, found.passed, "FALLS SHORT"),
                found.aim,
                _verdict(found.aim, found.aim_reached, "missed"),
            )
        )
    write("")
    write("Every limit is kept." if not failed else f"{failed} measures fall short.")
    write("Every aim is reached too." if not missed else f"{missed} of the aims are missed.")
    return not failed


def _measures(path: Path, repertoire: Repertoire) -> Iterator[Measure]:
    try:
        if repertoire.source == "spine":
            yield from measure_spine_driven(repertoire)
        else:
            yield from measure_simulated(motion_from_provenance(repertoire.provenance), repertoire)
    except msgspec.ValidationError as fault:
        raise UserError(f"attribute 'provenance' holds no plans ({fault})", file=path) from fault


def _line(name: str, value: str, at_least: str, passed: str, aim: str, reached: str) -> str:
    """A row of the table of measures."""
    cells = f"{name:<41} {value:>22}   {at_least:<12} {passed:<11}  {aim:<12} {reached}"
    return cells.rstrip()


def _verdict(target: str, reached: bool, missed: str) -> str:
    return "" if not target else "pass" if reached else missed


def _segment_rows(repertoire: Repertoire) -> Iterator[tuple[str, ...]]:
    length = repertoire.body_length_cm
    for name in sorted(repertoire.segments, key=_order):
        segment = repertoire.segments[name]
        frames = len(segment.nodes)
        per_second = segment.speed_cm_s / length
        yield (
            name,
            segment.pattern,
            segment.grade,
            str(frames),
            "yes" if segment.cyclic else "no",
            f"{segment.speed_cm_s:.2f}",
            f"{per_second:.3f}",
            f"{per_second * frames * repertoire.tick_s:.3f}" if segment.cyclic else "-",
            f"{segment.turn_deg:+.2f}",
            f"{segment.loop_error_bl:.1e}",
            f"{segment.bounding_radius_bl:.3f}",
            "no" if segment.control_points is None else str(segment.control_points.shape[1]),
        )


def _order(name: str) -> tuple[int, str]:
    return (SEGMENTS.index(name) if name in SEGMENTS else len(SEGMENTS), name)


def _table(rows: list[tuple[str, ...]]) -> Iterator[str]:
    """Lines of a table: words aligned to the left and numbers to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = [
            f"{cell:<{width}}" if column < 3 else f"{cell:>{width}}"
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        yield "  ".join(cells).rstrip()
