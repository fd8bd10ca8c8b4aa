"""Panels of the pages: each function draws one quantity on a matplotlib Axes."""

from typing import Any

import numpy as np

from capture.inspection.top_view import (
    TopView,
    above,
    lateral_offset,
    midline,
    spectrum,
    speeds,
    top_view,
)
from subsea.biomechanics.body import Floats
from subsea.biomechanics.body_plan import TurnPlan
from subsea.biomechanics.controllers import SpeedMap
from subsea.repertoire import SEGMENTS, Repertoire, Segment

CYCLES = 3
STRIP_FRAMES = 8, 16
POINTS = {"nose": "0.45", "origin": "#08519c", "tail": "#d94801"}
SEGMENT_COLOURS = {
    "swim_slow": "#9ecae1",
    "swim_medium": "#4292c6",
    "swim_fast": "#08519c",
    "turn_left_gradual": "#fdae6b",
    "turn_left_sharp": "#d94801",
    "turn_right_gradual": "#a1d99b",
    "turn_right_sharp": "#238b45",
}
BODY, FAINT = "#bdd7e7", "0.82"
X_COLOUR, Z_COLOUR = "#08306b", "0.6"
SCALES_CM = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100)
LEFT_EDGE, RIGHT_EDGE = (0, 1, 5, 9, 13, 17, 21), (21, 18, 14, 10, 6, 2, 0)
OUTLINE = LEFT_EDGE + RIGHT_EDGE
"""Nodes along the left flank to the tail and back along the right one."""
MAX_HZ = 12.0


def strip_limits(segment: Segment) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits of all pictures of the strip, to the right and ahead, cm."""
    played = top_view(segment, 1)
    tips = np.concatenate([played.origin + arrow for _, arrow in _arrows(played)])
    right, ahead = _screen(np.concatenate([played.nodes.ravel(), tips]))
    return _limits(right), _limits(ahead)


def strip_frames(segment: Segment) -> list[int]:
    """The frames of the strip: the last one, and others at equal intervals before it."""
    right, ahead = strip_limits(segment)
    # Narrower pictures leave room for more of them.
    most = np.clip(4.3 * np.ptp(ahead) / np.ptp(right), *STRIP_FRAMES)
    count = len(segment.nodes)
    return list(range(count - 1, -1, -int(np.ceil(count / most))))[::-1]


def strip(axes: Any, segment: Segment, tick_s: float) -> None:
    """The body from above in some frames, with the axes of earlier frames (SMC fig. 3).

    ``axes`` has one for each frame. Dark arrows are x and light ones z of the body frame.
    """
    played = top_view(segment, 1)
    count = len(played.origin)
    right, ahead = strip_limits(segment)
    every = max(1, count // 14)
    style = {"angles": "xy", "scale_units": "xy", "scale": 1, "units": "inches", "width": 0.013}
    for axis, k in zip(axes, strip_frames(segment), strict=True):
        axis.fill(*_screen(played.nodes[k, OUTLINE]), BODY, zorder=1)
        axis.plot(*_screen(played.midline[k]), "0.35", linewidth=0.8, zorder=2)
        for colour, arrow in _arrows(played):
            past = np.arange(k, -1, -every)
            shade = np.where(past == k, 1.0, 0.45)
            start = _screen(played.origin[past])
            axis.quiver(*start, *_screen(arrow[past]), color=colour, alpha=shade, zorder=3, **style)
        axis.set(xlim=right, ylim=ahead, aspect="equal", xticks=[], yticks=[])
        axis.spines[:].set(visible=True, color=FAINT)
        axis.set_title(f"{k + 1}\n{(k + 1) * tick_s:.2f} s", fontsize=10)
    axes[0].set_ylabel("frames from above, ahead is up", fontsize=10)
    scale = max(cm for cm in SCALES_CM if cm < 0.6 * (right[1] - right[0]))
    at = right[0] + 0.1 * (right[1] - right[0]), ahead[0] + 0.04 * (ahead[1] - ahead[0])
    axes[-1].plot([at[0], at[0] + scale], [at[1]] * 2, "k", linewidth=1.5)
    axes[-1].annotate(f"{scale:g} cm", at, xytext=(0, 3), textcoords="offset points", fontsize=9)


def _arrows(played: TopView) -> tuple[tuple[str, Any], tuple[str, Any]]:
    """Colours and arrows (t,) of the body axes z and x."""
    length = np.abs(played.midline[:, 0] - played.midline[:, -1]).max()
    return (Z_COLOUR, 0.25 * length * played.right), (X_COLOUR, 0.4 * length * played.forward)


def trajectories(ahead: Any, aside: Any, segment: Segment, tick_s: float) -> None:
    """Position of the body frame and the tail along x and z, over time."""
    played = top_view(segment, CYCLES)
    seconds = _seconds(played, tick_s)
    for name, points in (("origin", played.origin), ("tail", played.midline[:, -1])):
        ahead.plot(seconds, points.real, color=POINTS[name], label=name)
        aside.plot(seconds, -points.imag, color=POINTS[name], label=name)
    for axis, label in ((ahead, "x ahead, cm"), (aside, "z to the right, cm")):
        _mark_beats(axis, segment, tick_s)
        axis.set(xlabel="time, s", ylabel=label, xlim=(0, seconds[-1]))
    ahead.set_title("Ahead")
    aside.set_title("To the right")
    ahead.legend()


def path(axis: Any, segment: Segment) -> None:
    """Paths of nose, origin and tail from above."""
    played = top_view(segment, CYCLES)
    _draw_paths(axis, played)
    axis.set_aspect("equal", adjustable="datalim")
    axis.set(xlabel="z to the right, cm", ylabel="x ahead, cm", title="Path from above")
    axis.legend()


def _draw_paths(axis: Any, played: TopView) -> None:
    """Draw the paths of nose, tail and origin, and the last outline."""
    ends = {"nose": played.midline[:, 0], "tail": played.midline[:, -1], "origin": played.origin}
    for name, points in ends.items():
        axis.plot(*_screen(points), color=POINTS[name], label=name, linewidth=1)
    axis.fill(*_screen(played.nodes[-1, OUTLINE]), BODY, zorder=0)


def speed(axis: Any, segment: Segment, repertoire: Repertoire) -> None:
    """Speed in each frame, and its mean."""
    tick, length = repertoire.tick_s, repertoire.body_length_cm
    values = speeds(segment, tick, CYCLES)
    seconds = tick * (np.arange(len(values)) + 1.5)
    axis.plot(seconds, values, color=POINTS["origin"])
    axis.axhline(segment.speed_cm_s, color="0.5", linestyle="--", linewidth=1)
    axis.set(xlabel="time, s", ylabel="speed, cm/s", xlim=(0, seconds[-1]))
    axis.set_ylim(0, 1.25 * max(values.max(), segment.speed_cm_s))
    axis.set_title(f"Speed: {segment.speed_cm_s:.1f} cm/s, {segment.speed_cm_s / length:.2f} L/s")
    _mark_beats(axis, segment, tick)


def tail_sweep(axis: Any, segment: Segment, repertoire: Repertoire) -> None:
    """Offset of the tail to the right of the path, over time."""
    tick, length = repertoire.tick_s, repertoire.body_length_cm
    tail = lateral_offset(segment, CYCLES)[:, -1] / length
    if segment.cyclic:
        tail = tail - tail.mean()
    seconds = tick * np.arange(1, len(tail) + 1)
    axis.plot(seconds, tail, color=POINTS["tail"])
    axis.axhline(0, color=FAINT, linewidth=1, zorder=0)
    axis.set(xlabel="time, s", xlim=(0, seconds[-1]))
    axis.set_ylabel(f"right of {_reference(segment)}, L")
    axis.set_title(f"Tail sweep: {np.ptp(tail):.3f} L from side to side")
    _mark_beats(axis, segment, tick)


def tail_spectrum(axis: Any, segment: Segment, repertoire: Repertoire) -> None:
    """Spectrum of the tail's lateral motion."""
    tail = lateral_offset(segment)[:, -1] / repertoire.body_length_cm
    hertz, amplitude = spectrum(tail, repertoire.tick_s, segment.cyclic)
    seen = (hertz > 0) & (hertz <= max(MAX_HZ, hertz[1]))
    axis.vlines(hertz[seen], 0, amplitude[seen], color=POINTS["tail"], linewidth=3)
    strongest = hertz[seen][amplitude[seen].argmax()]
    axis.set(xlabel="frequency, Hz", ylabel="amplitude, L", xlim=(0, MAX_HZ))
    axis.set_ylim(bottom=0)
    axis.set_title(f"Spectrum of the tail: most at {strongest:.2f} Hz")


def envelope(axis: Any, segment: Segment, repertoire: Repertoire) -> None:
    """The midline in all frames and its envelope, from the nose to the tail."""
    length = repertoire.body_length_cm
    lines = lateral_offset(segment) / length
    rest = midline(repertoire.rest_nodes)[:, 0]
    behind = (rest[0] - rest) / length
    axis.fill_between(behind, lines.min(axis=0), lines.max(axis=0), color=BODY, alpha=0.6)
    step = max(1, len(lines) // 16)
    shades = np.linspace(0.75, 0.1, len(lines[::step]))
    for line, shade in zip(lines[::step], shades, strict=True):
        axis.plot(behind, line, color=str(shade), linewidth=0.8)
    axis.set(xlabel="behind the nose, L", xlim=(0, 1))
    axis.set_ylabel(f"right of {_reference(segment)}, L")
    axis.set_title("Midline in each frame (later is darker), and its envelope")


def closure(axis: Any, segment: Segment, first: Floats | None) -> None:
    """The last frame over the first one (23, 3), in body axes; None if unknown."""
    last = above(segment.nodes[-1])
    if first is not None:
        axis.fill(*_upright(above(first)[list(OUTLINE)]), BODY, label="first")
    axis.plot(*_upright(last[list(OUTLINE)]), color=POINTS["tail"], linewidth=1.2, label="last")
    axis.set_aspect("equal", adjustable="datalim")
    axis.set(xlabel="x, cm (body axes)", ylabel="z to the right, cm")
    axis.invert_yaxis()  # right is below when the nose is to the right
    kind = "Loop closure" if segment.cyclic else "First and last frame"
    axis.set_title(f"{kind}: {segment.loop_error_bl:.1e} L apart")
    axis.legend()


def paths(axes: Any, repertoire: Repertoire) -> None:
    """Paths of all segments from above, at one scale."""
    played = {name: top_view(one, CYCLES) for name, one in in_order(repertoire)}
    everything = np.concatenate([p.midline.ravel() for p in played.values()])
    width = max(np.ptp(_limits(-p.midline.imag.ravel())) for p in played.values())
    for axis, (name, one) in zip(axes, played.items(), strict=True):
        _draw_paths(axis, one)
        middle = np.mean(_limits(-one.midline.imag.ravel()))
        axis.set(ylim=_limits(everything.real), xlim=(middle - width / 2, middle + width / 2))
        axis.set_aspect("equal")
        axis.set_title(name.replace("turn_", "turn\n").replace("_", " "), fontsize=10)
        axis.set_xlabel("z, cm", fontsize=10)
        axis.tick_params(labelsize=9)
    axes[0].set_ylabel("x ahead, cm", fontsize=10)
    axes[0].legend(fontsize=9, loc="upper left")
    for axis in axes[1:]:
        axis.set_yticklabels([])


def speed_bars(axis: Any, repertoire: Repertoire) -> None:
    """The mean speed of each segment."""
    names = [name for name, _ in in_order(repertoire)][::-1]
    values = [repertoire.segments[name].speed_cm_s for name in names]
    colours = [SEGMENT_COLOURS.get(name, "0.5") for name in names]
    bars = axis.barh([name.replace("_", " ") for name in names], values, color=colours)
    texts = [f" {value / repertoire.body_length_cm:.2f} L/s" for value in values]
    axis.bar_label(bars, texts, fontsize=10)
    axis.set(xlabel="cm/s", title="Speed of each segment", xlim=(0, 1.25 * max(values)))


def tail_beats(axis: Any, repertoire: Repertoire) -> None:
    """The tail of all swims over time."""
    for name, segment in in_order(repertoire):
        if segment.pattern != "forward":
            continue
        tail = lateral_offset(segment, CYCLES)[:, -1] / repertoire.body_length_cm
        seconds = repertoire.tick_s * np.arange(1, len(tail) + 1)
        label = name.replace("_", " ")
        axis.plot(seconds, tail - tail.mean(), color=SEGMENT_COLOURS.get(name), label=label)
    axis.axhline(0, color=FAINT, linewidth=1, zorder=0)
    axis.set(xlabel="time, s", ylabel="right of the path, L", title="Tail beats")
    axis.margins(y=0.15)
    axis.legend(fontsize=9, loc="upper center", ncols=3)


def speed_control(axis: Any, levels: SpeedMap, length: float) -> None:
    """The steady speed at each amplitude of the beat."""
    axis.plot(levels.amplitude, 10 * levels.speed / length, "o-", color=POINTS["origin"], ms=4)
    axis.set(xlabel="amplitude of the beat", ylabel="steady speed, L/s", xlim=(0, 1.02))
    axis.set_ylim(bottom=0)
    axis.set_title("Speed controller")


def turned(axis: Any, asked: Floats, measured: Floats) -> None:
    """Measured angles (n, phases) against desired ones (n,); the map is for the first phase.

    An angle that was not measured is NaN.
    """
    top = 1.05 * np.fmax(asked.max(), np.fmax.reduce(measured, axis=None))
    axis.plot([0, top], [0, top], color=FAINT, linewidth=1, zorder=0)
    low, high = np.fmin.reduce(measured, axis=1), np.fmax.reduce(measured, axis=1)
    axis.vlines(asked, low, high, color=BODY, linewidth=5, label="entered at any phase")
    axis.plot(asked, measured[:, 0], "o", color=POINTS["tail"], ms=4, label="entered at phase 0")
    axis.set(xlabel="desired angle, °", ylabel="measured angle, °", title="Turns as measured")
    axis.set(xlim=(0, top), ylim=(0, top))
    axis.legend(fontsize=9)


def steering_map(axis: Any, turn: TurnPlan) -> None:
    """Bend, hold and restore times and contractions of the steering map, for each angle."""
    angles = [row.angle for row in turn.steering]
    stacked = np.array([(r.bend_ticks, r.hold_ticks, r.restore_ticks) for r in turn.steering]).T
    axis.stackplot(
        angles, stacked, labels=("bend", "hold", "restore"), colors=(FAINT, BODY, "#6baed6")
    )
    axis.set(xlabel="desired angle, °", ylabel="ticks", title="Steering map")
    axis.set(xlim=(angles[0], angles[-1]), ylim=(0, 1.3 * stacked.sum(axis=0).max()))
    other = axis.twinx()
    for place, (name, style) in enumerate((("anterior", "o-"), ("posterior", "s--"))):
        values = [row.contraction[place] for row in turn.steering]
        other.plot(angles, values, style, color=POINTS["tail"], ms=4, label=f"{name} contraction")
    other.set(ylabel="contraction", ylim=(0, 0.6))
    handles, labels = (
        a + b
        for a, b in zip(
            axis.get_legend_handles_labels(), other.get_legend_handles_labels(), strict=True
        )
    )
    axis.legend(handles, labels, fontsize=9, ncols=2, loc="upper left")


def note(axis: Any, words: str) -> None:
    """Write in place of a plot why there is none."""
    axis.text(0.5, 0.5, words, ha="center", va="center", wrap=True, transform=axis.transAxes)
    axis.set_axis_off()


def in_order(repertoire: Repertoire) -> list[tuple[str, Segment]]:
    """The segments by name: those of playback in its order, then others."""
    known = [name for name in SEGMENTS if name in repertoire.segments]
    others = [name for name in repertoire.segments if name not in SEGMENTS]
    return [(name, repertoire.segments[name]) for name in known + others]


def _seconds(played: TopView, tick_s: float) -> Floats:
    return np.asarray(tick_s * np.arange(1, len(played.origin) + 1))


def _screen(points: Any) -> tuple[Floats, Floats]:
    """Coordinates of a plot with ahead up: to the right, and ahead."""
    return -np.imag(points), np.real(points)


def _upright(points: Any) -> tuple[Floats, Floats]:
    """Coordinates of a plot with the nose to the right."""
    return np.real(points), -np.imag(points)


def _limits(values: Floats) -> tuple[float, float]:
    margin = 0.05 * np.ptp(values)
    return float(values.min() - margin), float(values.max() + margin)


def _mark_beats(axis: Any, segment: Segment, tick_s: float) -> None:
    """Mark the beginnings of cycles."""
    for cycle in range(1, CYCLES if segment.cyclic else 1):
        axis.axvline(cycle * len(segment.nodes) * tick_s, color=FAINT, linewidth=1, zorder=0)


def _reference(segment: Segment) -> str:
    return "the path" if segment.cyclic else "the body axis"
