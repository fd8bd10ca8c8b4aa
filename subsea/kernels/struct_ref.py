"""Groups of arrays that compiled kernels receive as one pointer.

A kernel with a named tuple of fifty arrays as argument contains code to unpack all of them, which
takes a second or more to compile for each kernel; every call unpacks them, too. A pointer to a
group compiles in a twentieth of that time. Kernels read `group.field` in both cases.

Kernels do not count references to a group or to its arrays, as they do with other arguments: the
named tuple keeps both alive. Counting takes locked instructions at each call of a function, for
which the cores of a computer wait for each other.
"""

import hashlib
from collections.abc import Callable
from contextlib import ExitStack
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from llvmlite import ir
from numba import typeof, types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    models,
    register_model,
    typeof_impl,
    unbox,
)

from subsea.kernels import kernel
from subsea.kernels.dispatch import POINTED

T = TypeVar("T")


class Kind(types.Type):  # type: ignore[misc]
    """Numba type of a group; each group has its own subclass at the top level of a module.

    Its name is short, as it is part of the names of all kernels that use it, and of their cache.
    """

    def __init__(self, fields: dict[str, Any]) -> None:
        self.fields = fields
        self.layout = types.Tuple(list(fields.values()))  # of its memory
        told = hashlib.sha256(str(fields).encode()).hexdigest()
        super().__init__(f"{type(self).__name__}.{told[:16]}")


@infer_getattr
class FieldTypes(AttributeTemplate):  # type: ignore[misc]
    """The type of a field of a group."""

    key = Kind

    def generic_resolve(self, kind: Kind, field: str) -> Any:
        """The type, or None for an unknown field."""
        return kind.fields.get(field)


@lower_getattr_generic(Kind)
def _field(context: Any, builder: Any, kind: Kind, pointer: Any, field: str) -> Any:
    """Load a field."""
    place = _place(context, builder, kind, pointer, list(kind.fields).index(field))
    return _uncounted(context, builder, kind.fields[field], _load(builder, place))


def _load(builder: Any, place: Any) -> Any:
    """Load what no kernel changes, part by part.

    The compiler keeps the addresses and sizes of arrays while a kernel writes into them. It would
    otherwise load them again after each number that is written, which might be one of them.
    """
    of = place.type.pointee
    if not isinstance(of, ir.Aggregate):
        value = builder.load(place)
        value.set_metadata("invariant.load", builder.module.add_metadata([]))
        return value
    value = ir.Constant(of, ir.Undefined)
    for k in range(len(of)):
        part = _load(builder, cgutils.gep_inbounds(builder, place, 0, k))
        value = builder.insert_value(value, part, k)
    return value


def _place(context: Any, builder: Any, kind: Kind, pointer: Any, number: int) -> Any:
    """Address of a field in the memory of a group."""
    layout = context.get_value_type(kind.layout)
    return cgutils.gep_inbounds(builder, builder.bitcast(pointer, layout.as_pointer()), 0, number)


def _uncounted(context: Any, builder: Any, of: Any, value: Any) -> Any:
    """A value whose arrays have no reference count."""
    if isinstance(of, types.Array):
        array = context.make_array(of)(context, builder, value)
        array.meminfo = cgutils.get_null_value(array.meminfo.type)
        array.parent = cgutils.get_null_value(array.parent.type)
        return array._getvalue()
    if isinstance(of, types.BaseTuple):
        for k, part in enumerate(of):
            one = _uncounted(context, builder, part, builder.extract_value(value, k))
            value = builder.insert_value(value, one, k)
    return value


@intrinsic
def _fill(context: Any, kind: Any, address: Any, values: Any) -> Any:
    """Write the fields of a group to an address; returns the size of its memory in bytes."""
    kind = kind.instance_type

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        _, address, values = arguments
        pointer = builder.inttoptr(address, cgutils.voidptr_t)
        for k in range(len(kind.fields)):
            place = _place(context, builder, kind, pointer, k)
            builder.store(builder.extract_value(values, k), place)
        layout = context.get_value_type(kind.layout)
        return context.get_constant(types.intp, context.get_abi_sizeof(layout))

    return types.intp(types.TypeRef(kind), address, values), code


def by_pointer(kind: type[Kind]) -> Callable[[type[T]], type[T]]:
    """Decorate a NamedTuple class so that kernels receive its instances by pointer.

    `kind` is the numba type of the group. The instance stays a named tuple in Python. A kernel
    cannot replace its fields; it can only write into fields that are arrays.
    """
    register_model(kind)(models.OpaqueModel)
    unbox(kind)(_unboxed)
    return lambda group: _pointed(group, kind)


def _unboxed(kind: Kind, group: Any, c: Any) -> Any:
    """The pointer to the memory of a group that is the argument of a kernel."""
    pointer = cgutils.alloca_once_value(c.builder, cgutils.get_null_value(cgutils.voidptr_t))
    failed = cgutils.alloca_once_value(c.builder, cgutils.true_bit)
    with ExitStack() as stack:
        address = c.pyapi.object_getattr_string(group, "_address")
        with cgutils.early_exit_if_null(c.builder, stack, address):
            pass  # Ctrl-C in the middle of a call
        c.builder.store(c.pyapi.long_as_voidptr(address), pointer)
        c.builder.store(cgutils.false_bit, failed)
        c.pyapi.decref(address)
    return NativeValue(c.builder.load(pointer), is_error=c.builder.load(failed))


def _pointed(group: Any, kind: Any) -> Any:
    name, fields = group.__name__, group._fields
    # A call of a kernel asks an object without it for `_numba_type_`. A named tuple takes ten times
    # as long, as the types of all its fields are looked up.
    del group._asdict

    class Group(group):  # type: ignore[misc]
        """A `group` with memory that has its fields, made when first needed."""

        @cached_property
        def _numba_type_(self) -> Any:
            return kind({field: typeof(value) for field, value in zip(fields, self, strict=True)})

        @cached_property
        def _address(self) -> int:
            memory = _memory(name, self._numba_type_, tuple(self))
            # Threads that both make it use the same, which stays.
            address: int = self.__dict__.setdefault("memory", memory).ctypes.data
            return address

        def __reduce__(self) -> Any:
            """A copy has memory of its own, which points to its own arrays."""
            return Group, tuple(self)

    Group.__name__, Group.__qualname__ = name, group.__qualname__
    Group.__module__, Group.__doc__ = group.__module__, group.__doc__
    POINTED.add(Group)
    typeof_impl.register(Group)(lambda value, _: value._numba_type_)
    return Group


FIELD_BYTES = 512  # more than any field takes

SOURCE = """
def fill_{name}(address, values):
    return fill(kind, address, values)
"""

_fillers: dict[Any, Any] = {}


def _memory(name: str, kind: Kind, values: tuple[Any, ...]) -> Any:
    """Memory that has the fields of a group."""
    if kind not in _fillers:
        # Compiled under this file's name, so that numba caches it with this file's kernels.
        names = {"fill": _fill, "kind": kind, "__name__": __name__}
        exec(compile(SOURCE.format(name=name.lower()), __file__, "exec"), names)
        _fillers[kind] = kernel(names[f"fill_{name.lower()}"])
    memory = np.zeros(FIELD_BYTES * len(values) // 8, np.int64)
    written_bytes = _fillers[kind](memory.ctypes.data, values)
    if written_bytes > memory.nbytes:
        raise MemoryError(f"the fields of {name} take {written_bytes} bytes of {memory.nbytes}")
    return memory
