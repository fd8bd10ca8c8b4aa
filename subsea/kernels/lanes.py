"""Lanes: one source of a kernel for one body and for eight bodies at once.

An element of type `Lanes` holds a number of each of LANES bodies, and compiles to a vector of the
processor. A kernel over arrays of such elements does for every lane the operations of the same
kernel over floats, in the same order. So each body gets the same bits alone and in a lane.

A plain inner loop over bodies does not become vector code: LLVM unrolls it before it vectorises
loops, and numba leaves out the pass that joins unrolled operations.

Lanes exist in compiled code alone. A kernel allocates float64 arrays (…, LANES) and takes them as
arrays (…) of lanes by `as_lanes`. Code for both kinds of elements

- has no branch on them: `max(0.0, a)` in place of `if a > 0.0`, `where_positive`, `first`;
- calls `math.sqrt`, not numpy's;
- makes its arrays by `room`, and begins sums with `zero_of`.
"""

import math
import operator
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_cast
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, overload, register_model

from subsea.base.arrays import Array, Ints
from subsea.kernels import kernel

LANES = 8  # one AVX-512 vector or two AVX2 vectors of float64; 16 are as fast, 4 slower


class Lanes(types.Type):  # type: ignore[misc]
    """Numba type of one float64 for each of LANES bodies."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")

    def can_convert_from(self, context: Any, other: Any) -> Any:
        """A number is the same number in every lane."""
        return Conversion.promote if isinstance(other, types.Float | types.Integer) else None


LANE = Lanes()
VECTOR = ir.VectorType(ir.DoubleType(), LANES)
INDEX = ir.IntType(32)
ALIGNMENT = 8  # bytes, of lanes in an array: numpy and numba align float64 alone


@register_model(Lanes)
class LanesModel(models.PrimitiveModel):  # type: ignore[misc]
    """A vector in registers and in memory."""

    def __init__(self, manager: Any, kind: Lanes) -> None:
        super().__init__(manager, kind, VECTOR)

    def load_from_data_pointer(self, builder: Any, pointer: Any, align: int | None = None) -> Any:
        """Load a vector; the default would be to expect it aligned to its size."""
        return builder.load(pointer, align=ALIGNMENT)


def _spread(builder: Any, value: Any) -> Any:
    """A float64 in every lane."""
    undefined = ir.Constant(VECTOR, ir.Undefined)
    vector = builder.insert_element(undefined, value, ir.Constant(INDEX, 0))
    return builder.shuffle_vector(
        vector, undefined, ir.Constant(ir.VectorType(INDEX, LANES), [0] * LANES)
    )


@lower_cast(types.Float, Lanes)
@lower_cast(types.Integer, Lanes)
def _of_number(context: Any, builder: Any, kind: Any, lanes: Any, value: Any) -> Any:
    return _spread(builder, context.cast(builder, value, kind, types.float64))


# Operators


def _vectors(builder: Any, kinds: Any, values: Any) -> list[Any]:
    return [
        value if isinstance(kind, Lanes) else _spread(builder, value)
        for kind, value in zip(kinds, values, strict=True)
    ]


class _Binary(AbstractTemplate):  # type: ignore[misc]
    """The type of an operation on two lanes, or on a lane and a number."""

    def generic(self, args: Any, kws: Any) -> Any:
        if len(args) != 2 or not any(isinstance(kind, Lanes) for kind in args):
            return None
        if not all(isinstance(kind, Lanes | types.Float | types.Integer) for kind in args):
            return None
        both = (kind if isinstance(kind, Lanes) else types.float64 for kind in args)
        return signature(LANE, *both)


class _Unary(AbstractTemplate):  # type: ignore[misc]
    """The type of an operation on a lane."""

    def generic(self, args: Any, kws: Any) -> Any:
        return signature(LANE, LANE) if len(args) == 1 and isinstance(args[0], Lanes) else None


def _define_binary(function: Any, operation: Any) -> None:
    """Compile ``function`` of lanes by ``operation`` (builder, a, b)."""
    infer_global(function)(type("Binary", (_Binary,), {}))

    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return operation(builder, *_vectors(builder, signature.args, values))

    for kinds in ((Lanes, Lanes), (Lanes, types.Float), (types.Float, Lanes)):
        lower_builtin(function, *kinds)(code)


def _define_unary(function: Any, operation: Any) -> None:
    """Compile ``function`` of lanes by ``operation`` (builder, a)."""
    infer_global(function)(type("Unary", (_Unary,), {}))

    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return operation(builder, *values)

    lower_builtin(function, Lanes)(code)


def _instruction(name: str) -> Any:
    return lambda builder, *values: getattr(builder, name)(*values)


def _choice(comparison: str) -> Any:
    """The choice of numba's `min` and `max`: the second where it compares so with the first."""
    return lambda builder, a, b: builder.select(builder.fcmp_ordered(comparison, b, a), b, a)


def _intrinsic(name: str) -> Any:
    def call(builder: Any, value: Any) -> Any:
        kind = ir.FunctionType(VECTOR, [VECTOR])
        function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{LANES}f64")
        return builder.call(function, [value])

    return call


for _functions, _name in (
    ((operator.add, operator.iadd), "fadd"),
    ((operator.sub, operator.isub), "fsub"),
    ((operator.mul, operator.imul), "fmul"),
    ((operator.truediv, operator.itruediv), "fdiv"),
):
    for _function in _functions:
        _define_binary(_function, _instruction(_name))
_define_binary(min, _choice("<"))
_define_binary(max, _choice(">"))
_define_unary(operator.neg, _instruction("fneg"))
_define_unary(math.sqrt, _intrinsic("sqrt"))
_define_unary(abs, _intrinsic("fabs"))
_define_unary(float, lambda builder, value: value)


@intrinsic
def lane(context: Any, value: Any, k: Any) -> Any:
    """The number of lane ``k``."""

    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.extract_element(values[0], builder.trunc(values[1], INDEX))

    return types.float64(value, types.int64), code


@intrinsic
def with_lane(context: Any, value: Any, k: Any, number: Any) -> Any:
    """Lanes with another number in lane ``k``."""

    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        vector, k, number = values
        return builder.insert_element(vector, number, builder.trunc(k, INDEX))

    return LANE(value, types.int64, types.float64), code


def _define_by_lanes(function: Any) -> None:
    """Compile a function of the C library for each lane in turn, which keeps its bits."""

    @overload(function, strict=False)
    def of_lanes(a: Any) -> Any:
        def each(a: Any) -> Any:
            for k in range(LANES):
                a = with_lane(a, k, function(lane(a, k)))
            return a

        return each if isinstance(a, Lanes) else None


_define_by_lanes(math.cos)
_define_by_lanes(math.sin)


# Choices


@intrinsic
def _positive(context: Any, test: Any, value: Any) -> Any:
    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        none = ir.Constant(VECTOR, [0.0] * LANES)
        return builder.select(builder.fcmp_ordered(">", values[0], none), values[1], none)

    return LANE(test, value), code


@intrinsic
def _any_positive(context: Any, value: Any) -> Any:
    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        bits = ir.IntType(LANES)
        above = builder.fcmp_ordered(">", values[0], ir.Constant(VECTOR, [0.0] * LANES))
        return builder.icmp_unsigned("!=", builder.bitcast(above, bits), ir.Constant(bits, 0))

    return types.boolean(value), code


def where_positive(test: float, value: float) -> float:
    """Choose ``value`` where ``test`` is positive, else 0."""
    return value if test > 0.0 else 0.0


@overload(where_positive, strict=False)
def _where_positive(test: Any, value: Any) -> Any:
    if isinstance(test, Lanes):
        return lambda test, value: _positive(test, value)
    return lambda test, value: value if test > 0.0 else 0.0


def any_positive(value: float) -> bool:
    """Test whether a number is positive, in any lane: a branch that no lane needs is left out."""
    return value > 0.0


@overload(any_positive, strict=False)
def _some_positive(value: Any) -> Any:
    if isinstance(value, Lanes):
        return lambda value: _any_positive(value)
    return lambda value: value > 0.0


def first(value: float) -> float:
    """The number of the first lane, for what all lanes have in common."""
    return value


@overload(first, strict=False)
def _first(value: Any) -> Any:
    if isinstance(value, Lanes):
        return lambda value: lane(value, 0)
    return lambda value: value


# Arrays


@intrinsic
def as_lanes(context: Any, array: Any) -> Any:
    """View a C-contiguous float64 array (…, LANES) as an array (…) of lanes."""
    if not isinstance(array, types.Array) or array.layout != "C" or array.dtype != types.float64:
        return None
    view = types.Array(LANE, array.ndim - 1, "C", aligned=False)

    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        source = cgutils.create_struct_proxy(signature.args[0])(context, builder, values[0])
        result = cgutils.create_struct_proxy(view)(context, builder)
        shape = cgutils.unpack_tuple(builder, source.shape)[:-1]
        strides = cgutils.unpack_tuple(builder, source.strides)[:-1]
        number = source.nitems.type
        result.meminfo, result.parent = source.meminfo, source.parent
        result.itemsize = ir.Constant(number, 8 * LANES)
        result.nitems = builder.sdiv(source.nitems, ir.Constant(number, LANES))
        result.data = builder.bitcast(source.data, result.data.type)
        result.shape = cgutils.pack_array(builder, shape)
        result.strides = cgutils.pack_array(builder, strides)
        context.nrt.incref(builder, signature.args[0], values[0])
        return result._getvalue()

    return view(array), code


@intrinsic
def uncounted(context: Any, array: Any) -> Any:
    """View an array without counting references, which another array keeps alive.

    Counting takes locked instructions wherever an array is named or passed on.
    """

    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        source = cgutils.create_struct_proxy(signature.args[0])(context, builder, values[0])
        source.meminfo = cgutils.get_null_value(source.meminfo.type)
        source.parent = cgutils.get_null_value(source.parent.type)
        return source._getvalue()

    return array(array), code


def room(shape: tuple[int, ...], like: Array) -> Array:
    """Make an array of a shape for elements of the kind of an array ``like``, with any content."""
    return np.empty(shape)


@overload(room, strict=False)
def _room(shape: Any, like: Any) -> Any:
    if isinstance(like.dtype, Lanes):
        return lambda shape, like: as_lanes(np.empty((*shape, LANES)))
    return lambda shape, like: np.empty(shape)


def zero_of(like: Array) -> float:
    """Zero, as an element of the kind of an array ``like``."""
    return 0.0


@intrinsic
def _zero(context: Any) -> Any:
    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return ir.Constant(VECTOR, [0.0] * LANES)

    return LANE(), code


@overload(zero_of, strict=False)
def _zero_of(like: Any) -> Any:
    if isinstance(like.dtype, Lanes):
        return lambda like: _zero()
    return lambda like: 0.0


@kernel
def gather(rows: Array, who: Ints) -> Array:
    """Copy rows ``who`` of an array (n, …) into lanes: float64 (…, LANES).

    ``who`` has 1 to LANES indices; the last one also fills the lanes that remain. Rows must be
    contiguous.
    """
    out = np.empty((*rows.shape[1:], LANES))
    flat = out.reshape(-1, LANES)
    for k in range(LANES):
        row = rows[who[min(k, len(who) - 1)]].reshape(-1)
        for place in range(len(row)):
            flat[place, k] = row[place]
    return out


@kernel
def take_lane(lanes: Array, k: int, out: Array) -> None:
    """Copy lane ``k`` of float64 (…, LANES) into an array (…)."""
    flat, row = lanes.reshape(-1, LANES), out.reshape(-1)
    for place in range(len(row)):
        row[place] = flat[place, k]
