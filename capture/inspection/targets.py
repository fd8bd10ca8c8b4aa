"""A measure of motion beside its targets, as `subsea-capture inspect` shows it."""

from typing import NamedTuple

import numpy as np


class Measure(NamedTuple):
    """One line of the report: the measured value, two targets, and whether they are reached.

    ``at_least`` is asked of every species; ``aim`` is where the best should get. An empty target
    asks nothing.
    """

    name: str
    value: str
    at_least: str = ""
    passed: bool = True
    aim: str = ""
    aim_reached: bool = True


class Range(NamedTuple):
    """A target: where a measure should lie. NaN lies nowhere."""

    low: float = -np.inf
    high: float = np.inf

    def holds(self, *values: float) -> bool:
        """Whether all values lie within."""
        return all(self.low <= value <= self.high for value in values)

    def text(self, unit: str) -> str:
        """As a person reads it: ``≥ 0.35 L``, ``± 3°``, ``0.15-0.25 L``."""
        if self.high == np.inf:
            words = f"≥ {self.low:g}"
        elif self.low == -np.inf:
            words = f"≤ {self.high:g}" if self.high >= 0.01 else f"≤ {self.high:.0e}"
        elif self.low == -self.high:
            words = f"± {self.high:g}"
        else:
            words = f"{self.low:g}-{self.high:g}"
        return words.replace("e-0", "e-") + unit


def least(low: float) -> Range:
    """``low`` or more."""
    return Range(low=low)


def most(high: float) -> Range:
    """``high`` or less."""
    return Range(high=high)


def off(most: float) -> Range:
    """No farther from zero than ``most``, to either side."""
    return Range(-most, most)


def judge(
    name: str,
    values: float | tuple[float, ...],
    form: str,
    unit: str,
    at_least: Range,
    aim: Range | None = None,
) -> Measure:
    """The line for one value or several, each written in the format ``form`` with its unit."""
    several = values if isinstance(values, tuple) else (values,)
    return Measure(
        name,
        ", ".join(f"{value:{form}}{unit}" for value in several),
        at_least.text(unit),
        at_least.holds(*several),
        aim.text(unit) if aim else "",
        aim.holds(*several) if aim else True,
    )
