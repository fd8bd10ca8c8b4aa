"""Declare an array of the state once: dtype, shape, unit, writer, start value and range.

A group is a class whose annotations read `Annotated[F32, motor("n", 3, unit="cm"), "text"]`.
Integers of a common meaning have a type with their start value and range, such as `FISH`. Empty
arrays, snapshots, checksums and `docs/reference/state.md` are derived from the annotations.
"""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Annotated, Any, NamedTuple, TypeVar, get_type_hints

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.state.codes import COURTSHIP, HUNT, NOBODY, SUBMARINE

G = TypeVar("G")

F32 = Annotated[Array, np.dtype(np.float32)]
F64 = Annotated[Array, np.dtype(np.float64)]
NUMBER = Annotated[float, np.dtype(np.float64)]
I8 = Annotated[Ints, np.dtype(np.int8)]
I32 = Annotated[Ints, np.dtype(np.int32)]
I64 = Annotated[Ints, np.dtype(np.int64)]
U8 = Annotated[Ints, np.dtype(np.uint8)]
U16 = Annotated[Ints, np.dtype(np.uint16)]
BOOL = Annotated[Bools, np.dtype(np.bool_)]
FISH = Annotated[I32, {"start": NOBODY, "within": (NOBODY, "n")}]
FISH_OR_HULL = Annotated[I32, {"start": NOBODY, "within": (SUBMARINE, "n")}]
FOOD = Annotated[I32, {"start": -1, "within": (-1, "food")}]  # a speck; of a predator: a fish
SITE = Annotated[I32, {"start": -1, "within": (-1, "sites")}]  # of `Sea.site_kind`
ROW = Annotated[I32, {"within": (0, "rows")}]  # of the motion library
SEGMENT = Annotated[U8, {"within": (0, "segments")}]
HUNT_PHASE = Annotated[U8, {"within": (0, len(HUNT))}]
COURTSHIP_STATE = Annotated[U8, {"within": (0, len(COURTSHIP))}]

CREATION, PANELS = "creation", "panels"  # writers of arrays that no tick changes


class Spec(NamedTuple):
    """Declaration of an array, or of a number if it has no dimension."""

    shape: tuple[int | str, ...]  # a word is a size of the group
    writer: str
    unit: str = ""
    start: Any = 0  # broadcast to the shape
    within: tuple[int, int | str] | None = None  # of integers: lowest, and an upper bound
    dtype: np.dtype[Any] = np.dtype(np.float64)  # this and ...
    about: str = ""  # ... this come from the annotation

    @property
    def saved(self) -> bool:
        """True if a tick may change it, so that a snapshot holds it."""
        return self.writer not in (CREATION, PANELS)

    @property
    def may_be_infinite(self) -> bool:
        """True if infinity (never, nowhere) is a valid value."""
        return bool(np.isinf(self.start).any())

    def empty(self, sizes: Mapping[str, int]) -> Any:
        """The array with its start values, or the number."""
        if not self.shape:
            return self.dtype.type(self.start).item()
        shape = [size if isinstance(size, int) else sizes[size] for size in self.shape]
        array = np.empty(shape, self.dtype)
        array[...] = self.start
        return array


def written_by(writer: str) -> Callable[..., Spec]:
    """A function that declares arrays of one writer: dimensions, then other fields of `Spec`.

    Integers that a tick writes need a range `within`.
    """
    return lambda *shape, **rest: Spec(shape, writer, **rest)


creation, panels = written_by(CREATION), written_by(PANELS)
perception, behavior, motor = map(written_by, ("perception", "behavior", "motor"))
habitat, submarine, directing = map(written_by, ("habitat", "submarine", "directing"))


@cache
def declared(group: type) -> dict[str, Spec]:
    """Declaration of each member of a group, in order."""
    specs = {}
    for name, hint in get_type_hints(group, include_extras=True).items():
        dtype, *common, spec, about = hint.__metadata__
        specs[name] = spec._replace(dtype=dtype, about=about, **dict(*common))
    return specs


def starts(group: type, given: Mapping[str, Any], sizes: Mapping[str, int]) -> dict[str, Any]:
    """All members of a group by name: those `given`, and start values for the others."""
    specs = declared(group).items()
    return {name: spec.empty(sizes) for name, spec in specs if name not in given} | dict(given)


def empty(group: type[G], *, given: Mapping[str, Any] | None = None, **sizes: int) -> G:
    """Make a named tuple whose members have their start values, except those that are `given`."""
    return group(**starts(group, given or {}, sizes))
