"""Shader sources with `#include "file"`, once each, and line numbers that stay correct.

The shader cache of the graphics driver.
"""

import os
import re
import shutil
from contextlib import suppress
from pathlib import Path
from typing import Any

from moderngl import Uniform

from subsea.base.errors import UserError
from subsea.base.system import resource_path
from subsea.rendering.gl import view_block

MIN_FREE_BYTES = 256 << 20


def avoid_full_disk() -> None:
    """Turn Mesa's shader cache off on an almost full disk; call this before a context is made.

    Mesa maps the index of its cache into memory. If the disk has no room left when it writes there,
    the system ends the process (SIGBUS).
    """
    folder = Path(
        os.environ.get("MESA_SHADER_CACHE_DIR")
        or os.environ.get("XDG_CACHE_HOME")
        or Path.home() / ".cache"
    ).absolute()
    with suppress(OSError):
        there = next(place for place in (folder, *folder.parents) if place.exists())
        if shutil.disk_usage(there).free < MIN_FREE_BYTES:
            os.environ.setdefault("MESA_SHADER_CACHE_DISABLE", "true")


VERSION = "#version 330 core\n"
_INCLUDE = re.compile(r'^\s*#include\s+"([^"]+)"\s*$')


def program(context: Any, name: str, **constants: int) -> Any:
    """Compile `shaders/NAME.vert` and `shaders/NAME.frag` with these `constants` defined."""
    return context.program(
        vertex_shader=source(f"{name}.vert", **constants),
        fragment_shader=source(f"{name}.frag", **constants),
    )


def required_defines(uniforms: dict[str, Any], as_ids: bool = False) -> tuple[str, ...]:
    """The defines that select a program variant.

    OBJECT_IDS to draw object ids; LIT with lamps on; SUN_MAP and FISH_MAP with maps of shadows.

    Separate variants, because a software renderer would walk every branch for every pixel.
    """
    if as_ids:
        return ("OBJECT_IDS",)
    needs = {"LIT": "u_lamps", "SUN_MAP": "u_sun_map", "FISH_MAP": "u_fish_map"}
    return tuple(define for define, uniform in needs.items() if uniform in uniforms)


def source(name: str, **constants: int) -> str:
    """The text of one shader with its includes, after a `#define` for each constant."""
    defined = "".join(f"#define {key} {value}\n" for key, value in constants.items())
    return VERSION + defined + "\n".join(_lines(name, {})) + "\n"


def _lines(name: str, seen: dict[str, int]) -> list[str]:
    """The lines of a file; `#line` reports errors by the number of the file in `seen`."""
    number = seen.setdefault(name, len(seen))
    out = [f"#line 1 {number}"]
    path = resource_path(f"shaders/{name}")
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as fault:
        raise UserError(
            f"cannot read this part of the program ({fault.strerror})", file=path
        ) from fault
    for count, line in enumerate(text.splitlines(), start=1):
        include = _INCLUDE.match(line)
        if include is None:
            out.append(line)
        elif include[1] not in seen:
            out += [*_lines(include[1], seen), f"#line {count + 1} {number}"]
    return out


def set_uniforms(target: Any, **values: Any) -> None:
    """Set the uniforms that the program uses and whose value has changed.

    Those of the view are taken from `view`, the content of its block, or by their names. Must be
    the only way to set uniforms: `extra` of each caches its last value.
    """
    if target.extra is None:
        members = {name: target[name] for name in target}
        own = {name: one for name, one in members.items() if isinstance(one, Uniform)}
        target.extra = own, view_block.NAME in members
        if view_block.NAME in members:
            members[view_block.NAME].binding = view_block.BINDING
    own, sees = target.extra
    if sees:
        content = values.get("view") or view_block.view_block(values)
        target.ctx.extra.view.write(content)
    for name, uniform in own.items():  # fewer than the values
        value = values.get(name)
        if value is not None and uniform.extra != value:
            uniform.extra = value
            if isinstance(value, bytes):
                uniform.write(value)
            else:
                uniform.value = value
