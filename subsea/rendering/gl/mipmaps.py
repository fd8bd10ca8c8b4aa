"""Mipmapped textures, cached on disk.

A software renderer compiles a program for each format that it makes mipmaps of, which takes 0.05 s
at every start.
"""

import ctypes
from collections.abc import Callable
from typing import Any, ParamSpec

import moderngl
import numpy as np
from numpy.typing import NDArray

from subsea.base.disk_cache import cache_name, cached

P = ParamSpec("P")
Texels = NDArray[Any]  # half floats or bytes (h, w, c), bottom row first

# OpenGL enums; formats by the number of planes.
TEXTURE_2D, MAX_LEVEL, UNSIGNED_BYTE, HALF_FLOAT = 0x0DE1, 0x813D, 0x1401, 0x140B
PLANES = 0x1903, 0x8227, 0x1907, 0x1908
HALVES, BYTES = (0x822D, 0x822F, 0x881B, 0x881A), (0x8229, 0x822B, 0x8051, 0x8058)
SRGB8_ALPHA8 = 0x8C43  # for colours in sRGB
ALL = 1000  # levels: down to one texel


def mipmapped(context: Any, texels: Texels, last: int = ALL, srgb: bool = False) -> Any:
    """Make a texture with mipmaps up to level `last`."""
    texture = _plain(context, texels, srgb)
    texture.build_mipmaps(max_level=last)
    return texture


def cached_texture(
    context: Any,
    last: int,
    srgb: bool,
    make: Callable[P, Texels],
    *given: P.args,
    **named: P.kwargs,
) -> Any:
    """As `mipmapped`, of `make(*given, **named)`; texels and mipmaps are cached on disk."""

    # `of` and `driver` are parts of the cache key.
    def levels(of: str, driver: tuple[str, ...], last: int, srgb: bool) -> list[Texels]:
        base = make(*given, **named)
        texture = mipmapped(context, base, last, srgb)
        found = [base]
        for level in range(1, min(max(base.shape[:2]).bit_length() - 1, last) + 1):
            height, width = (max(side >> level, 1) for side in base.shape[:2])
            data = np.frombuffer(texture.read(level=level), base.dtype)
            found.append(data.reshape(height, width, -1))
        texture.release()
        return found

    driver = context.info["GL_RENDERER"], context.info["GL_VERSION"]
    base, *smaller = cached(levels, cache_name(make, *given, **named), driver, last, srgb)
    texture = _plain(context, base, srgb)
    texture.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
    # moderngl cannot upload single levels.
    write = gl_function(context, "glTexImage2D", *[ctypes.c_int] * 8, ctypes.c_void_p)
    limit = gl_function(context, "glTexParameteri", *[ctypes.c_int] * 3)
    texture.use()
    for level, data in enumerate(smaller, start=1):
        height, width, planes = data.shape
        form = PLANES[planes - 1], UNSIGNED_BYTE if data.dtype == np.uint8 else HALF_FLOAT
        own = _format(data, srgb)
        write(TEXTURE_2D, level, own, width, height, 0, *form, data.ctypes.data)
    limit(TEXTURE_2D, MAX_LEVEL, len(smaller))
    return texture


def _plain(context: Any, texels: Texels, srgb: bool) -> Any:
    height, width, planes = texels.shape
    kind = "f1" if texels.dtype == np.uint8 else "f2"
    data, own = np.ascontiguousarray(texels), _format(texels, srgb)
    return context.texture((width, height), planes, data, dtype=kind, internal_format=own)


def _format(texels: Texels, srgb: bool) -> int:
    formats = BYTES if texels.dtype == np.uint8 else HALVES
    return SRGB8_ALPHA8 if srgb else formats[texels.shape[2] - 1]


def gl_function(context: Any, name: str, *types: Any) -> Any:
    """A function of OpenGL that moderngl does not wrap, with the types of its arguments."""
    address = context.mglo._context.load_opengl_function(name)
    return ctypes.CFUNCTYPE(None, *types)(address)
