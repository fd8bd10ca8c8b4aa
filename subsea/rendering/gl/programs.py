"""Programs with variants that are compiled on demand: for object ids, lamps, fades, close-ups."""

import re
from collections.abc import Callable
from typing import Any

from subsea.base.arrays import Array
from subsea.rendering.gl.context import GpuOwner
from subsea.rendering.gl.id_buffer import object_id
from subsea.rendering.gl.shaders import program, required_defines, set_uniforms


class ProgramVariants(GpuOwner):
    """A program, its variants, and the vertex arrays that any of them draws."""

    def __init__(
        self,
        context: Any,
        name: str,
        ids: int | Callable[[], Array] | None = None,
        first: tuple[str, ...] = (),
        **constants: int,
    ) -> None:
        """Compile `shaders/NAME`; `ids` is a kind, or returns the object id of each vertex.

        `first` are the defines of the variant that is compiled at once (`Quality.defines`), the
        `constants` those of all variants.
        """
        super().__init__()
        self.context, self._name, self._ids, self._first = context, name, ids, first
        self._constants = constants
        compiled = self.own(program(context, name, **dict.fromkeys(first, 1), **constants))
        self._programs: dict[tuple[str, ...], Any] = {first: compiled}
        self._contents: dict[Any, tuple[Any, Any]] = {}
        self._arrays: dict[Any, Any] = {}

    def array(self, content: list[Any], indices: Any = None) -> Any:
        """Make a vertex array of the first program; arguments as in moderngl."""
        array = self.own(self.context.vertex_array(self._programs[self._first], content, indices))
        self._contents[array] = content, indices
        return array

    def ready(
        self, array: Any, as_ids: bool, wants: tuple[str, ...] = (), /, **uniforms: Any
    ) -> Any:
        """Return `array`, or its twin for the variant needed, with these uniforms set.

        `wants` are defines beside those that the uniforms require.
        """
        defines = wants + required_defines(uniforms, as_ids)
        array = self.variant(array, defines)
        if isinstance(self._ids, int):
            uniforms["u_object_id"] = object_id(self._ids)
        set_uniforms(array.program, **uniforms)
        return array

    def variant(self, array: Any, defines: tuple[str, ...]) -> Any:
        """Return `array`, or its twin for the program with these defines, compiled if needed."""
        if defines == self._first:
            return array
        if defines not in self._programs:
            own = self._constants | ({"OWN_IDS": 1} if callable(self._ids) else {})
            compiled = program(self.context, self._name, **dict.fromkeys(defines, 1), **own)
            self._programs[defines] = self.own(compiled)
        if (array, defines) not in self._arrays:
            content, indices = self._contents[array]
            if callable(self._ids) and "OBJECT_IDS" in defines:
                ids = self.own(self.context.buffer(self._ids().astype("f4")))
                content = [*content, (ids, "1f4", "a_object_id")]
            twin = variant_array(self.context, self._programs[defines], content, indices)
            self._arrays[array, defines] = self.own(twin)
        return self._arrays[array, defines]


def variant_array(context: Any, compiled: Any, content: Any, indices: Any = None) -> Any:
    """Make a vertex array whose content may hold attributes that the program lacks."""
    kept = [_without_missing(compiled, *part) for part in content]
    return context.vertex_array(compiled, kept, indices, skip_errors=True)


def _without_missing(compiled: Any, buffer: Any, layout: str, *names: str) -> tuple[Any, ...]:
    """Pass over attributes that the program lacks: moderngl would bind them to no place."""
    formats, shown = layout.split(), []
    for k, name in enumerate(names):
        if name in compiled:
            shown.append(name)
        else:
            number, kind, size = re.match(r"(\d*)([a-z]+)(\d)", formats[k]).groups()  # type: ignore[union-attr]
            formats[k] = formats[k].replace(
                f"{number}{kind}{size}", f"{int(number or 1) * int(size)}x", 1
            )
    return buffer, " ".join(formats), *shown
