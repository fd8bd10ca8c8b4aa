"""Compare a repertoire with measured fishes (assets/swimming.toml)."""

from collections.abc import Iterator
from typing import NamedTuple

import msgspec
import numpy as np

from capture.inspection.kinematics import (
    BodyWave,
    body_wave,
    envelope_deviation,
    escape,
    posture,
    turning,
    turning_radius,
    wing_amplitude,
)
from capture.inspection.report import (
    coast_drag,
    eel_glide_drag,
    expected_strouhal,
    glide_drag,
    ray_glide_drag,
)
from capture.recording.record import motion_from_provenance
from subsea.base.findings import RangeCheck
from subsea.biomechanics.solver import TIME_UNIT_S
from subsea.fish.measured import MeasuredSwimming, PostureFacts, SwimmingFacts, published
from subsea.fish.species import Species
from subsea.repertoire import Repertoire

FULL_TEMPO = 3.0  # fastest playback over recorded, of swims and C-starts
ROW_TEMPO = 1.5  # fastest beat of the pectoral fins over recorded
ENVELOPE_L = 0.02  # greatest deviation from the published envelope
BAINBRIDGE_HZ = 5.0  # his line holds above
BAINBRIDGE_CM = 50.0  # his fishes were shorter
NEAR = 0.3  # relative distance from a line that counts as near
SWIMS = ("swim_slow", "swim_medium", "swim_fast", "swim_burst")
TURNS = tuple(
    f"turn_{side}_{grade}"
    for grade in ("sharp", "rest", "glide", "gradual", "row", "coast")
    for side in ("left", "right")
)
ROW = "row_forward"
ESCAPES = ("cstart_left_moderate", "cstart_left_wide")  # right ones mirror them
BEAT = 20  # ticks at the end of a turn, over which its course is measured
NAN = float("nan")


class Swim(NamedTuple):
    """One steady swim of an adult at the recorded tempo."""

    name: str
    speed: float  # L/s
    frequency: float  # Hz
    amplitude: float  # peak to peak, L
    wave: BodyWave

    @property
    def stride(self) -> float:
        """Body lengths a beat."""
        return self.speed / self.frequency

    @property
    def strouhal(self) -> float:
        """Frequency times amplitude over speed."""
        return self.frequency * self.amplitude / self.speed


class Validated(NamedTuple):
    """The measures of one species, for tables and plots."""

    species: str
    facts: SwimmingFacts
    adult_cm: float  # middle of the sizes of adults
    rate: float  # frames of an adult over those of the recorded fish
    swims: list[Swim]  # those recorded, from slow to burst
    expected: float  # Strouhal number for the drag of an adult; NaN for eels and rays
    findings: list[RangeCheck]


def bainbridge(frequency: float) -> float:
    """Speed in L/s of Bainbridge's dace, trout and goldfish (1958)."""
    return 0.25 * (3.0 * frequency - 4.0)


def adult_rate(adult_cm: float, recorded_cm: float) -> float:
    """Playback rate of an adult by Froude similarity, as in `subsea.world.populate`."""
    return float((adult_cm / recorded_cm) ** -0.5)


def validate(repertoire: Repertoire, species: Species, table: MeasuredSwimming) -> Validated:
    """Measure a repertoire, as an adult of its species swims it."""
    facts = table.species[repertoire.species]
    adult = 0.5 * sum(species.size_cm)
    rate = species.pace * adult_rate(adult, repertoire.body_length_cm)
    swims = [_swim(name, repertoire, rate, facts) for name in SWIMS if name in repertoire.segments]
    fast = next(swim for swim in swims if swim.name == "swim_fast")
    expected = NAN
    if facts.wave == "carangiform":
        expected = expected_strouhal(species.surface, adult, fast.speed * adult)
    found = Validated(repertoire.species, facts, adult, rate, swims, expected, [])
    found.findings.extend(
        [
            *_waves(found),
            *_postures(found, repertoire, table.posture),
            *_speeds(found),
            *_rowing(found, repertoire),
            *_turns(found, repertoire),
            *_bends(found, repertoire, table.posture),
            *_escapes(found, repertoire),
            *_drag(found, repertoire, species, table),
        ]
    )
    return found


def _swim(name: str, repertoire: Repertoire, rate: float, facts: SwimmingFacts) -> Swim:
    segment = repertoire.segments[name]
    length = repertoire.body_length_cm
    wave = body_wave(segment, repertoire)
    amplitude, frequency = wave.amplitude, wave.frequency
    if facts.gait == "ray":
        amplitude = wing_amplitude(segment, length)
        frequency = 1.0 / (len(segment.nodes) * repertoire.tick_s)
    return Swim(name, rate * segment.speed_cm_s / length, rate * frequency, amplitude, wave)


def _waves(found: Validated) -> Iterator[RangeCheck]:
    """Envelope, wavelength, amplitude, stride and Strouhal number."""
    name, facts = found.species, found.facts
    fast = next(swim for swim in found.swims if swim.name == "swim_fast")
    if facts.wave != "none":
        off, at = envelope_deviation(facts.wave, fast.wave)
        source = "anguilliform wave" if facts.wave == "anguilliform" else "borazjani_2008"
        note = f"worst at {at:.2f} L"
        yield RangeCheck(name, "envelope off the published one, fast", off, " L", 0.0, ENVELOPE_L,
                      source, note)  # fmt: skip
    if facts.wavelength:
        yield published(name, "wavelength, fast", fast.wave.wavelength, " L", facts.wavelength)
    if facts.amplitude:
        yield published(name, "tail amplitude, fast", fast.amplitude, " L", facts.amplitude)
        slow = found.swims[0]
        measured = facts.slow_amplitude or facts.amplitude
        yield published(name, "tail amplitude, slow", slow.amplitude, " L", measured)
    yield published(name, "stride, fast", fast.stride, " L", facts.stride)
    yield published(name, "Strouhal number, fast", fast.strouhal, "", facts.strouhal)
    if facts.wave == "carangiform":
        low, high = (1 - NEAR) * found.expected, (1 + NEAR) * found.expected
        yield RangeCheck(name, "Strouhal number for its size, fast", fast.strouhal, "", low, high,
                      "lighthill_1971 (estimate)", f"{found.adult_cm:.0f} cm")  # fmt: skip


def _postures(
    found: Validated, repertoire: Repertoire, facts: PostureFacts
) -> Iterator[RangeCheck]:
    """Compare the posture at every grade, and beats over speeds."""
    name = found.species
    if found.facts.wave != "carangiform":
        return
    for swim in found.swims:
        grade = swim.name.removeprefix("swim_")
        held = posture(repertoire.segments[swim.name], swim.wave)
        length = swim.wave.wavelength
        yield published(name, f"snout over tail, {grade}", held.snout_over_tail, "",
                        facts.snout_over_tail)  # fmt: skip
        yield published(name, f"body wavelength, {grade}", length, " L", facts.wavelength)
        yield published(name, f"yaw of the head, {grade}", held.yaw, "°", facts.yaw)
        yield published(name, f"bend of the snout, {grade}", held.snout, "°", facts.snout)
        yield published(name, f"roll, {grade}", held.roll, "°", facts.roll)
    if found.adult_cm < BAINBRIDGE_CM:
        cruising = [swim for swim in found.swims if swim.name != "swim_burst"]
        speeds, beats = (
            [getattr(swim, key) for swim in cruising] for key in ("speed", "frequency")
        )
        slope, intercept = np.polyfit(speeds, beats, 1)
        yield published(name, "beat over speed: slope", float(slope), "", facts.slope)
        yield published(name, "beat over speed: intercept", float(intercept), " Hz",
                        facts.intercept)  # fmt: skip


def _speeds(found: Validated) -> Iterator[RangeCheck]:
    """Speeds and beats of an adult, and Bainbridge's line."""
    name, facts = found.species, found.facts
    swims = {swim.name: swim for swim in found.swims}
    fast = swims["swim_fast"]
    yield published(name, "speed, slow", swims["swim_slow"].speed, " L/s", facts.slow)
    yield published(name, "speed, fastest cruise", fast.speed, " L/s", facts.cruise)
    burst = swims.get("swim_burst", fast)
    note = f"{burst.name} {FULL_TEMPO:g} times as fast"
    yield published(name, "speed, burst", FULL_TEMPO * burst.speed, " L/s", facts.burst, note)
    yield published(name, "beat, fastest cruise", fast.frequency, " Hz", facts.beat)
    top = FULL_TEMPO * burst.frequency
    if facts.wave == "carangiform" and found.adult_cm < BAINBRIDGE_CM:
        ratio = FULL_TEMPO * burst.speed / bainbridge(top) if top > BAINBRIDGE_HZ else NAN
        yield RangeCheck(name, "burst over Bainbridge's speed at its beat", ratio, "", 1 - NEAR,
                      1 + NEAR, "bainbridge_1958", f"{top:.1f} Hz")  # fmt: skip


def _rowing(found: Validated, repertoire: Repertoire) -> Iterator[RangeCheck]:
    """Fastest speed with pectoral fins alone, of those that row."""
    if found.facts.gait_change:
        row, speed = repertoire.segments.get(ROW), NAN
        if row:
            speed = ROW_TEMPO * found.rate * row.speed_cm_s / repertoire.body_length_cm
        yield published(found.species, "speed, pectoral fins alone", speed, " L/s",
                        found.facts.gait_change)  # fmt: skip


def _turns(found: Validated, repertoire: Repertoire) -> Iterator[RangeCheck]:
    """The tightest of the recorded turns, and each."""
    radius = {
        name: turning_radius(segment, repertoire.body_length_cm)
        for name in TURNS
        if (segment := repertoire.segments.get(name))
    }
    least = min(radius, key=lambda name: radius[name], default="")
    yield published(
        found.species, "turning radius, least", radius.get(least, NAN), " L", found.facts.radius,
        least,
    )  # fmt: skip


def _bends(found: Validated, repertoire: Repertoire, facts: PostureFacts) -> Iterator[RangeCheck]:
    """Compare every turn, of species that bend."""
    if found.facts.wave != "carangiform":
        return
    second = found.rate / repertoire.tick_s  # recorded ticks in a second of an adult
    for name in TURNS:
        if segment := repertoire.segments.get(name):
            seen = turning(segment, repertoire.body_length_cm, "left" in name, BEAT)
            if not np.isnan(seen.into):
                yield published(found.species, f"{name}: bent into the turn", seen.into, "",
                                facts.into_turn)  # fmt: skip
            yield published(found.species, f"{name}: acceleration", second**2 * seen.acceleration,
                            " L/s²", facts.acceleration)  # fmt: skip
            yield RangeCheck(found.species, f"{name}: net angle", seen.net, "°")
            yield RangeCheck(found.species, f"{name}: speed aside", second * seen.aside, " L/s")


def _escapes(found: Validated, repertoire: Repertoire) -> Iterator[RangeCheck]:
    """Net angle of C-starts and their duration at full tempo; no range where none is published."""
    facts = found.facts
    for name in ESCAPES:
        angle, duration = NAN, NAN
        if segment := repertoire.segments.get(name):
            duration = escape(segment, repertoire.tick_s / (FULL_TEMPO * found.rate))
            angle = turning(segment, repertoire.body_length_cm, True, BEAT).net
        for quantity, value, unit, measured in (
            (f"{name}: net angle", angle, "°", facts.escape_angle),
            (f"{name}: duration", duration, " s", facts.escape_duration),
        ):
            if measured:
                yield published(found.species, quantity, value, unit, measured)
            elif segment:
                yield RangeCheck(found.species, quantity, value, unit)


def _drag(
    found: Validated, repertoire: Repertoire, species: Species, table: MeasuredSwimming
) -> Iterator[RangeCheck]:
    """Drag of the passive body that coasts from its fastest cruise."""
    speed = repertoire.segments["swim_fast"].speed_cm_s * TIME_UNIT_S
    try:
        if species.spine and species.spine.muscles:
            drag = eel_glide_drag(species.spine, species.surface, speed)
        elif species.spine and species.spine.wings and species.spine.wings.muscles:
            drag = ray_glide_drag(species.spine, species.surface, speed)
        else:
            motion = motion_from_provenance(repertoire.provenance)
            drag = glide_drag(motion, species.surface, speed)
    except msgspec.ValidationError:
        return
    yield published(found.species, "drag coefficient of a glide", drag, "", table.coasting.drag)
    if coast := repertoire.segments.get("swim_coast"):
        drag = coast_drag(motion, species.surface, coast)
        note = "recorded coast"
        yield published(found.species, "drag coefficient of a coast", drag, "",
                        table.coasting.drag, note)  # fmt: skip
