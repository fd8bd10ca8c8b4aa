"""Groups of arrays that compiled kernels receive as one pointer.

A kernel with a named tuple of fifty arrays as argument contains code to unpack all of them, which
takes a second or more to compile for each kernel; every call unpacks them, too. A pointer to a
group compiles in a twentieth of that time. Kernels read `group.field` in both cases.
"""

import hashlib
from collections.abc import Callable
from typing import Any, TypeVar

from numba import typeof, types
from numba.core import cgutils
from numba.experimental import structref
from numba.extending import intrinsic, typeof_impl

from subsea.core.kernels import kernel

T = TypeVar("T")


class Kind(types.StructRef):  # type: ignore[misc]
    """Numba type of a group; each group has its own subclass at the top level of a module.

    Otherwise numba would name the type by all its fields: some thousand characters in the names of
    all kernels that use it and in their cache.
    """

    def __init__(self, fields: Any) -> None:
        super().__init__(fields)
        told = hashlib.sha256(str(self).encode()).hexdigest()
        self.name = f"{self._typename}.{told[:16]}"


@intrinsic  # type: ignore[untyped-decorator]
def uncounted(context: Any, value: Any) -> Any:
    """An array whose references are not counted, or anything else as it is.

    Kernels would count references to the arrays of a group at every turn, with locked instructions
    for which the cores of a computer wait for each other. The named tuple keeps the arrays alive.
    """

    def code(target: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        (given,) = arguments
        if not isinstance(value, types.Array):
            target.nrt.incref(builder, value, given)
            return given
        array = target.make_array(value)(target, builder, given)
        array.meminfo = cgutils.get_null_value(array.meminfo.type)
        array.parent = cgutils.get_null_value(array.parent.type)
        return array._getvalue()

    return value(value), code


SOURCE = """
def {name}(arrays):
    group = new(kind)
    {fields}
    return group
"""


def by_pointer(kind: type[Kind]) -> Callable[[type[T]], type[T]]:
    """Decorate a NamedTuple class so that kernels receive its instances by pointer.

    `kind` is the numba type of the group. The instance stays a named tuple in Python. A kernel
    cannot replace its fields; it can only write into fields that are arrays.
    """
    return lambda group: _pointed(group, structref.register(kind))


def _pointed(group: Any, kind: Any) -> Any:
    name, fields = group.__name__, group._fields

    class Group(group):  # type: ignore[misc]
        """A `group` with a pointer to it, made when first needed."""

        @property
        def _numba_type_(self) -> Any:
            if "kind" not in self.__dict__:
                self.__dict__["kind"] = kind(
                    [(field, typeof(value)) for field, value in zip(fields, self, strict=True)]
                )
            return self.__dict__["kind"]

        @property
        def _meminfo(self) -> Any:
            if "pointer" not in self.__dict__:
                self.__dict__["pointer"] = _maker(name, fields, self._numba_type_)(tuple(self))
            return self.__dict__["pointer"]

        @staticmethod
        def _numba_box_(kind: Any, pointer: Any) -> Any:
            return pointer

    Group.__name__, Group.__qualname__ = name, group.__qualname__
    Group.__module__, Group.__doc__ = group.__module__, group.__doc__
    structref.define_boxing(kind, Group)
    typeof_impl.register(Group)(lambda value, _: value._numba_type_)
    return Group


_makers: dict[Any, Any] = {}


def _maker(name: str, fields: tuple[str, ...], kind: Any) -> Any:
    """The kernel that allocates a group of this type and fills in its fields."""
    if kind not in _makers:
        lines = "\n    ".join(
            f"group.{field} = uncounted(arrays[{k}])" for k, field in enumerate(fields)
        )
        source = SOURCE.format(name=f"make_{name.lower()}", fields=lines)
        # Compiled under this file's name, so that numba caches it with this file's kernels.
        names = {
            "new": structref.new, "uncounted": uncounted, "kind": kind, "__name__": __name__
        }  # fmt: skip
        exec(compile(source, __file__, "exec"), names)
        _makers[kind] = kernel(names[f"make_{name.lower()}"])
    return _makers[kind]
