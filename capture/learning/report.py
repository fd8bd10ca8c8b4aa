"""Report what learning a body and its gaits has found."""

from collections.abc import Iterator

from capture.learning.lifelike import grade_waves, missed_aims
from capture.learning.whole import Learned
from subsea.biomechanics.body import build_body
from subsea.biomechanics.solver import TICK_S

COLUMNS = (
    "ticks",
    "amplitude",
    "L/s",
    "stride, L",
    "tail, L",
    "Strouhal",
    "wave, L",
    "envelope, L",
)


def report(name: str, learned: Learned) -> Iterator[str]:
    """Lines: a table of the grades, and the aims that the fast one misses."""
    if learned.muscles is None:
        why = f", the last candidate as {learned.notes[-1]}" if learned.notes else ""
        yield f"{name}: nothing was found{why}; the file is unchanged, try a larger --budget"
        return
    plan, swim, turn = learned.muscles
    body = build_body(plan)
    waves = grade_waves(body, swim)
    yield f"{name:<24}" + "".join(f"{column:>12}" for column in COLUMNS)
    for grade, wave in waves.items():
        ticks = swim.at(grade).ticks_per_beat
        speed = wave.stride / (ticks * TICK_S)
        values = (speed, wave.stride, wave.tail, wave.strouhal, wave.wavelength, wave.envelope)
        cells = f"{ticks:>12}{swim.amplitude(grade):>12.3f}"
        yield f"  {grade:<22}{cells}" + "".join(f"{value:>12.3f}" for value in values)
    yield f"  turns: {', '.join(f'{row.angle:g}°' for row in turn.steering)}, sharp {turn.sharp:g}°"
    missed = missed_aims(waves["fast"])
    if missed:
        yield f"  fast misses: {'; '.join(missed)}"
