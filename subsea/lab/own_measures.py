"""Measures of your own: functions over the arrays of a record."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from subsea.base.errors import UserError, nearest
from subsea.base.registry import MEASURES, load_named
from subsea.lab.functions import identified, name_of, parameters_of, raised, short
from subsea.media.record import Record

Own = float | None | dict[str, float | None]
WHOLE = "record"  # the parameter that gets all of it


@dataclass(frozen=True)
class OwnMeasure:
    """A function of a record that returns a number, or several with names."""

    function: Callable[..., Any]

    def __post_init__(self) -> None:
        """Refuse a function with unknown parameters: a UserError."""
        if not callable(self.function):
            raise TypeError(f"measures: expected functions, got {self.function!r}")
        try:
            wanted = parameters_of(self.function)
        except (TypeError, ValueError):
            self._fail("the names of its parameters are unknown; wrap it in a function of Python")
        known = [WHOLE, *Record._fields]
        for one in wanted:
            if one not in known:
                hint = nearest(one, known) or f"; expected some of {', '.join(known)}"
                self._fail(f"unknown parameter {one!r}{hint}")

    @property
    def name(self) -> str:
        """The name of the function."""
        return name_of(self.function)

    @property
    def description(self) -> str:
        """The names of its module and function, and a hash of its text and of its bound values."""
        return identified(self.function)

    def of(self, record: Record) -> Own:
        """Measure a record; a UserError if the function raises or returns no number."""
        given = {
            name: record if name == WHOLE else getattr(record, name)
            for name in parameters_of(self.function)
        }
        try:
            found = self.function(**given)
        except Exception as fault:
            self._fail(raised(fault), fault)
        if isinstance(found, Mapping):
            return {str(name): self._number(one) for name, one in found.items()}
        return self._number(found)

    def _number(self, value: Any) -> float | None:
        """Check a number; None and NaN mean that there is nothing to measure."""
        if value is None:
            return None
        if not isinstance(value, str | bytes) and np.ndim(value) == 0:
            try:
                number = float(value)
            except (TypeError, ValueError):
                number = math.inf
            if not math.isinf(number):
                return None if math.isnan(number) else number
        return self._fail(
            f"returned {short(value)}, expected a finite number, None, or a table of numbers"
        )

    def _fail(self, why: str, fault: Exception | None = None) -> Any:
        raise UserError(f"measure {name_of(self.function)}: {why}") from fault


def own_measures(functions: Iterable[Callable[..., Any]]) -> tuple[OwnMeasure, ...]:
    """Make measures of functions; a UserError for two of one name."""
    found = tuple(OwnMeasure(one) for one in functions)
    names = [one.name.lower() for one in found]
    for name in names:
        if names.count(name) > 1:
            raise UserError(f"measures: two functions are named {name}; rename one")
    return found


def named_measures(names: Iterable[str]) -> tuple[OwnMeasure, ...]:
    """Load measures of other packages by the names of their entry points; a UserError if none."""
    return own_measures(load_named(MEASURES, name, "measure") for name in names)
