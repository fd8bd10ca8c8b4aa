"""Shader programs and their uniforms.

Sources have `#include "file"`, once each, and line numbers that stay correct. The uniforms of a
view are in one buffer that all programs share, see `shaders/view.glsl`: set one by one in each
program, they took a sixth of the renderer's own time.
"""

import re
import struct
from functools import cache
from pathlib import Path
from typing import Any

from moderngl import Uniform

from subsea.base.errors import UserError
from subsea.base.system import resource_path

VERSION = "#version 330 core\n"
_INCLUDE = re.compile(r'^\s*#include\s+"([^"]+)"\s*$')

_SAMPLERS = (
    "u_table", "u_caustics", "u_noise", "u_skins", "u_vertices", "u_places", "u_relief", "u_leaves",
    "u_waves", "u_ground", "u_ripples", "u_litter", "u_tracks", "u_grain", "u_polyps", "u_sun_map",
    "u_fish_map", "u_shafts", "u_mask", "u_bloom", "u_early_suns", "u_late_suns",
)  # fmt: skip
TEXTURE_UNITS = {name: unit for unit, name in enumerate(_SAMPLERS)}
"""The texture unit of each sampler; any other sampler reads unit 0."""

# Defines that select a variant of a program, by the uniforms that need the variant. There are
# variants because a software renderer would walk every branch for every pixel.
NEEDS = {
    "INTEGERS": "u_integers",  # the canvas holds integers
    "CLOSE_UP": "u_close_up",  # details that show at arm's length
    "LIT": "u_lamps",
    "SUN_MAP": "u_sun_view",
    "FISH_MAP": "u_fish_view",
    "PASSES": "u_passes",  # the parts of the light, for compositing
}

BLOCKS = {"Looks": 0, "View": 1}  # bindings of uniform blocks
# The members of the view's buffer: matrices of 64 bytes, and numbers of floats.
_MATRIX = 16
_MEMBERS = {
    "u_view": _MATRIX, "u_projection": _MATRIX, "u_view_projection": _MATRIX, "u_inverse": _MATRIX,
    "u_eye": 3, "u_time": 1, "u_balance": 3, "u_far": 3, "u_broad": 3, "u_narrow": 3, "u_unit": 1,
}  # fmt: skip
# Their places in the layout std140: three floats end with a gap, unless a single one follows.
_VIEW = struct.Struct("=64s64s64s64s3f1f3f4x3f4x3f4x3f1f")


def program(context: Any, name: str, **constants: int) -> Any:
    """Compile `shaders/NAME.vert` and `shaders/NAME.frag` with these `constants` defined."""
    return context.program(
        vertex_shader=source(f"{name}.vert", **constants),
        fragment_shader=source(f"{name}.frag", **constants),
    )


def required_defines(uniforms: dict[str, Any], as_ids: bool = False) -> tuple[str, ...]:
    """Return the defines of the program variant for these uniforms, or for object ids."""
    if as_ids:
        return ("OBJECT_IDS",)
    return tuple(define for define, uniform in NEEDS.items() if uniform in uniforms)


def source(name: str, **constants: int) -> str:
    """The text of one shader with its includes, after a `#define` for each constant."""
    defined = "".join(f"#define {key} {value}\n" for key, value in constants.items())
    return VERSION + defined + "\n".join(_lines(name, {})) + "\n"


def _lines(name: str, seen: dict[str, int]) -> list[str]:
    """The lines of a file; `#line` reports errors by the number of the file in `seen`."""
    number = seen.setdefault(name, len(seen))
    out = [f"#line 1 {number}"]
    for count, (line, included) in enumerate(_read(resource_path(f"shaders/{name}")), start=1):
        if not included:
            out.append(line)
        elif included not in seen:
            out += [*_lines(included, seen), f"#line {count + 1} {number}"]
    return out


@cache  # most files are included by many programs
def _read(path: Path) -> list[tuple[str, str]]:
    """Read the lines of a file, each with the file that it includes, if any."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as fault:
        raise UserError(
            f"cannot read this part of the program ({fault.strerror})", file=path
        ) from fault
    includes = ((line, _INCLUDE.match(line)) for line in text.splitlines())
    return [(line, include[1] if include else "") for line, include in includes]


def set_uniforms(target: Any, **values: Any) -> None:
    """Set the uniforms that the program uses and whose value has changed.

    Those of the view are taken from `view`, the content of its buffer, or by their names. Must be
    the only way to set uniforms: `extra` of each caches its last value.
    """
    if target.extra is None:
        members = {name: target[name] for name in target}
        uniforms = {name: member for name, member in members.items() if isinstance(member, Uniform)}
        target.extra = uniforms, "View" in members
        for name in TEXTURE_UNITS.keys() & uniforms.keys():
            uniforms.pop(name).value = TEXTURE_UNITS[name]
        for name in BLOCKS.keys() & members.keys():
            members[name].binding = BLOCKS[name]
    uniforms, sees = target.extra
    if sees:
        target.ctx.extra.view.write(values.get("view") or view_block(values))
    for name, uniform in uniforms.items():  # fewer than the values
        value = values.get(name)
        if value is not None and uniform.extra != value:
            uniform.extra = value
            if isinstance(value, bytes):
                uniform.write(value)
            else:
                uniform.value = value


def view_block(values: dict[str, Any]) -> bytes:
    """Pack the content of the view's buffer: matrices as bytes, vectors, the time."""
    parts: list[Any] = []
    for name, number in _MEMBERS.items():
        value = values.get(name)
        if number == _MATRIX:
            parts.append(bytes(64) if value is None else value)
        elif number == 1:
            parts.append(value or 0.0)
        else:
            parts += (0.0,) * number if value is None else value
    return _VIEW.pack(*parts)


class ViewBuffer:
    """The buffer of a context, which holds the view that is drawn."""

    def __init__(self, context: Any) -> None:
        """Bind the buffer for all programs of the context."""
        self._buffer = context.buffer(reserve=_VIEW.size)
        self._buffer.bind_to_uniform_block(BLOCKS["View"])
        self._content = b""

    def write(self, content: bytes) -> None:
        """Write the content of a view, unless it is there."""
        if content != self._content:
            self._buffer.write(content)
            self._content = content
