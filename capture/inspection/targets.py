"""A measure of motion and its targets, as `subsea-capture inspect` shows them."""

from typing import NamedTuple

import numpy as np


class Measure(NamedTuple):
    """One line of the report; ``limit`` is for every species, ``aim`` for good ones."""

    name: str
    value: str
    limit: str = ""
    passed: bool = True
    aim: str = ""
    aim_reached: bool = True


class Range(NamedTuple):
    """A target range of a measure, ends included; NaN is outside every range."""

    low: float = -np.inf
    high: float = np.inf

    def holds(self, *values: float) -> bool:
        """True if all values are inside."""
        return all(self.low <= value <= self.high for value in values)

    def text(self, unit: str) -> str:
        """The range as text: ``≥ 0.35 L``, ``± 3°``, ``0.15-0.25 L``."""
        if self.high == np.inf:
            words = f"≥ {self.low:g}"
        elif self.low == -np.inf:
            words = f"≤ {self.high:g}" if self.high >= 0.01 else f"≤ {self.high:.0e}"
        elif self.low == -self.high:
            words = f"± {self.high:g}"
        else:
            words = f"{self.low:g}-{self.high:g}"
        return words.replace("e-0", "e-") + unit


def at_least(low: float) -> Range:
    """``low`` or more."""
    return Range(low=low)


def at_most(high: float) -> Range:
    """``high`` or less."""
    return Range(high=high)


def within(bound: float) -> Range:
    """From ``-bound`` to ``bound``."""
    return Range(-bound, bound)


def limit_at_phase_0(angle: float) -> Range:
    """Range of the error of a turn by ``angle`` degrees that begins at phase 0."""
    return within(3.0 if angle <= 60 else 6.0)


def limit_at_any_phase(angle: float) -> Range:
    """Range of the error of a turn by ``angle`` degrees that begins at any phase."""
    return within(7.0 if angle <= 60 else 10.0)


def compare(
    name: str,
    values: float | tuple[float, ...],
    form: str,
    unit: str,
    limit: Range,
    aim: Range | None = None,
) -> Measure:
    """The measure of one or several values, in the format ``form`` with a unit.

    Values are compared as they are shown: 0.3496, shown as 0.350, is at least 0.35.
    """
    texts = [f"{value:{form}}" for value in (values if isinstance(values, tuple) else (values,))]
    several = [float(text) for text in texts]
    return Measure(
        name,
        ", ".join(f"{text}{unit}" for text in texts),
        limit.text(unit),
        limit.holds(*several),
        aim.text(unit) if aim else "",
        aim.holds(*several) if aim else True,
    )
