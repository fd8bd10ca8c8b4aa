"""Choose what tests do every day, and leave the rest to `make nightly`."""

from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import settings


def examples(number: int) -> int:
    """Scale a number of costly examples as the profile scales the default of 25."""
    return number * settings.default.max_examples // 25


def only(daily: Any, every: Iterable[Any]) -> list[Any]:
    """Parametrise with `every` value, or tuple of values; those not in `daily` at night."""
    every = list(every)
    assert set(daily) <= set(every), f"{daily} are not all of {every}"
    return [
        pytest.param(
            *(value if isinstance(value, tuple) else [value]),
            marks=() if value in daily else pytest.mark.nightly,
        )
        for value in every
    ]
