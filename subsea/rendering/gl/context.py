"""OpenGL contexts, headless through EGL or on an existing window, and owners of their objects.

A timer measures the stages of a picture on the GPU by timer queries (OpenGL 3.3).
"""

import ctypes
import os
import shutil
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from pathlib import Path
from typing import Any, TypeVar

import moderngl
import numpy as np

from subsea.base.errors import UserError
from subsea.base.system import INSTALL_HEADLESS
from subsea.rendering.gl.shaders import ViewBuffer

T = TypeVar("T")

MIN_FREE_BYTES = 256 << 20  # of the disk, for Mesa's shader cache

# Of a picture, in the order of drawing; several views add up.
GPU_STAGES = (
    "shafts", "stone", "corals", "seaweed", "sand", "shadows", "water", "fishes", "particles",
    "output",
)  # fmt: skip
NOTHING = nullcontext()
UNKNOWN_S = 4.2  # drivers count nanoseconds in 32 bits: longer times mean nothing


class GpuTimer:
    """Measures whole pictures, or while it is `on` their stages, which do not overlap.

    moderngl cannot free queries: they exist as long as their context, and are used again.
    """

    def __init__(self, context: Any) -> None:
        self.on = False
        self._context = context
        self._whole = context.extra.picture_query
        self._drawn = False  # a picture is measured as a whole, and not read yet
        self._queries: list[Any] = []
        self._names: list[str] = []  # of the queries since the last call of `seconds`

    def picture(self) -> AbstractContextManager[object]:
        """Measure the picture that is drawn within the context, unless its stages are measured."""
        if self.on:
            return NOTHING
        self._drawn = True
        query: AbstractContextManager[object] = self._whole
        return query

    def wait(self) -> float:
        """Wait until the GPU has drawn the last `picture`; seconds that it took, 0 if unknown."""
        if not self._drawn:
            return 0.0
        self._drawn = False
        seconds = 1e-9 * self._whole.elapsed
        return seconds if seconds < UNKNOWN_S else 0.0

    def stage(self, name: str) -> AbstractContextManager[object]:
        """Measure the drawing calls within the context."""
        if not self.on:
            return NOTHING
        if len(self._names) == len(self._queries):
            self._queries.append(self._context.query(time=True))
        self._names.append(name)
        query: AbstractContextManager[object] = self._queries[len(self._names) - 1]
        return query

    def flush(self) -> None:
        """Let the GPU begin what it was asked for."""
        gl_function(self._context, "glFlush")()

    def seconds(self) -> dict[str, float]:
        """Seconds in each stage since the last call; waits until the GPU is done."""
        spent = dict.fromkeys(GPU_STAGES, 0.0)
        for name, query in zip(self._names, self._queries, strict=False):
            spent[name] += 1e-9 * query.elapsed
        self._names.clear()
        return spent


class GpuOwner:
    """Base class of everything that holds OpenGL objects."""

    def __init__(self) -> None:
        self._owned: list[Any] = []

    def own(self, made: T) -> T:
        """Register `made`, anything with a method `release`, as owned, and return it."""
        self._owned.append(made)
        return made

    def disown(self, part: T) -> T:
        """Give up an owned object, which somebody else owns from now on, and return it."""
        self._owned = [owned for owned in self._owned if owned is not part]
        return part

    def own_buffers(self, context: Any, *parts: Any) -> list[Any]:
        """Upload arrays to buffers, one each."""
        return [self.own(context.buffer(np.ascontiguousarray(part))) for part in parts]

    def release(self) -> None:
        """Release every owned object, the last one first."""
        while self._owned:
            self._owned.pop().release()


def replace_data(buffer: Any, data: Any) -> None:
    """Write a contiguous array to a buffer; draws in progress keep the old data."""
    buffer.orphan(data.nbytes)
    buffer.write(data)


BACK_BUFFERS = (0x0402, 0x0403)  # OpenGL's names for the left and right one
REQUIRED = 330  # OpenGL 3.3 core
# Variables that select drivers.
DRIVER_SETTINGS = ("LIBGL_", "MESA_", "GALLIUM_", "EGL_", "__EGL_", "__GLX_")


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


def headless_context() -> Any:
    """Make a context without a window; UserError if OpenGL is missing or too old."""
    avoid_full_disk()
    # Messages of Mesa would hide the line that says what to install.
    os.environ.setdefault("EGL_LOG_LEVEL", "fatal")
    try:  # moderngl raises plain Exceptions
        context = _create(standalone=True, backend="egl")
    except Exception as egl_fault:
        # Systems other than Linux make hidden windows instead.
        try:
            context = _create(standalone=True)
        except Exception:
            raise _no_opengl(egl_fault) from egl_fault
    return _prepared(context)


class _Loader:
    """Lets moderngl find OpenGL functions through the window library."""

    def __init__(self, get_proc_address: Callable[[str], int | None]) -> None:
        self._look_up = get_proc_address

    def load_opengl_function(self, name: str) -> int:
        return self._look_up(name) or 0

    def release(self) -> None:
        pass  # the window owns the context

    def __enter__(self) -> "_Loader":
        return self

    def __exit__(self, *arguments: object) -> None:
        pass


def window_context(get_proc_address: Callable[[str], int | None]) -> Any:
    """Make a context on the current window, for example with ``glfw.get_proc_address``."""
    try:
        context = _create(context=_Loader(get_proc_address))
    except Exception as fault:
        raise _no_opengl(fault) from fault
    return _prepared(context)


def gl_function(context: Any, name: str, *types: Any, result: Any = None) -> Any:
    """Return a function of OpenGL that moderngl does not wrap, with arguments of these types."""
    address = context.mglo._context.load_opengl_function(name)
    return ctypes.CFUNCTYPE(result, *types)(address)


def page_switch(context: Any) -> Callable[[int], None]:
    """Return a function that selects the left (0) or right (1) buffer of the window in use."""
    draw_buffer = gl_function(context, "glDrawBuffer", ctypes.c_uint)
    return lambda number: draw_buffer(BACK_BUFFERS[number])


def _create(**settings: Any) -> Any:
    return moderngl.create_context(require=REQUIRED, **settings)


class _DrawCallCounter:
    """The `scope` of every vertex array, which counts and times its drawing calls.

    It also has the one timer query of whole pictures, as moderngl cannot free queries, and the
    buffer of the view that is drawn.
    """

    def __init__(self, picture_query: Any, view: ViewBuffer) -> None:
        self.picture_query = picture_query
        self.view = view
        with picture_query:  # only then it counts as an object
            pass
        self.calls = 0
        self.seconds = 0.0
        self._start = 0.0

    def __enter__(self) -> None:
        self._start = time.perf_counter()

    def __exit__(self, *arguments: object) -> None:
        self.calls += 1
        self.seconds += time.perf_counter() - self._start


def _prepared(context: Any) -> Any:
    """Free dropped objects, and count the drawing calls of all vertex arrays in `extra`."""
    context.gc_mode = "auto"  # without it dropped objects are never freed
    context.extra = tally = _DrawCallCounter(context.query(time=True), ViewBuffer(context))
    make, release = context.vertex_array, context.release

    def release_for_good() -> None:
        # OpenGL has freed all objects of a released context. Freeing one that Python drops later
        # would free the object of the same number in whichever context is current then.
        context.gc_mode = None
        release()

    def counted(*arguments: Any, **settings: Any) -> Any:
        array = make(*arguments, **settings)
        array.scope = tally
        return array

    context.vertex_array, context.release = counted, release_for_good
    return context


def opengl_remedy(install: str) -> str:
    """A remedy without OpenGL: unset variables that select drivers, or run a command."""
    settings = [f"{name}={value}" for name, value in os.environ.items()
             if name.startswith(DRIVER_SETTINGS)]  # fmt: skip
    command = f"on Debian or Ubuntu: {install}"
    return f"try without {' '.join(sorted(settings))}, or {command}" if settings else command


def _no_opengl(fault: Exception) -> UserError:
    reason = str(fault).splitlines()[0] if str(fault) else type(fault).__name__
    return UserError(f"no OpenGL 3.3 ({reason}); {opengl_remedy(INSTALL_HEADLESS)}")
