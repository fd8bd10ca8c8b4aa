"""A measure of motion and its targets, as `subsea-capture inspect` shows them."""

from typing import NamedTuple

import numpy as np


class Measure(NamedTuple):
    """One line of the report: a measured value and two targets; an empty target is none.

    ``limit`` holds for every species, ``aim`` is the goal for good ones.
    """

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
        """Whether all values are inside."""
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


def compare(
    name: str,
    values: float | tuple[float, ...],
    form: str,
    unit: str,
    limit: Range,
    aim: Range | None = None,
) -> Measure:
    """The measure of one or several values, in the format ``form`` with a unit."""
    several = values if isinstance(values, tuple) else (values,)
    return Measure(
        name,
        ", ".join(f"{value:{form}}{unit}" for value in several),
        limit.text(unit),
        limit.holds(*several),
        aim.text(unit) if aim else "",
        aim.holds(*several) if aim else True,
    )
