"""The runtime: its instance and system, the OpenGL context it draws with, and its errors.

The functions get the module `xr` from their caller, the one module that imports it.
"""

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

from subsea.base.errors import UserError
from subsea.stage.headset.controllers import HAND_INTERACTION

OPENGL = "XR_KHR_opengl_enable"
NO_RUNTIME = (
    "no OpenXR runtime: install the software of the headset, SteamVR or Monado, and make it the "
    "active OpenXR runtime in its settings"
)
NOT_RUNNING = "the OpenXR runtime does not start: start the software of the headset, then try again"
NO_HEADSET = "no headset: connect it, switch it on and start its software"
NO_OPENGL = "the OpenXR runtime does not support OpenGL: make SteamVR or Monado the active one"
NO_CONTEXT = "OpenXR needs a window on X11: unset WAYLAND_DISPLAY, or set it to nothing"


@contextmanager
def opening(xr: Any) -> Iterator[None]:
    """Turn what the runtime reports into a UserError."""
    try:
        yield
    except xr.RuntimeUnavailableError as fault:
        raise UserError(NO_RUNTIME) from fault
    except (xr.FormFactorUnavailableError, xr.FormFactorUnsupportedError) as fault:
        raise UserError(NO_HEADSET) from fault
    except (xr.RuntimeFailureError, xr.InitializationFailedError) as fault:
        raise UserError(NOT_RUNNING) from fault
    except xr.XrException as fault:
        raise UserError(f"the headset does not open: {first_line(fault)}") from fault


def make_instance(xr: Any, made: ExitStack, graphics: bool) -> tuple[Any, set[str]]:
    """Make an instance, which `made` destroys; also the extensions that are enabled in it.

    `graphics`: a UserError if the runtime does not support OpenGL.
    """
    offered = {_text(one.extension_name) for one in xr.enumerate_instance_extension_properties()}
    wanted = {OPENGL, HAND_INTERACTION} & offered
    if graphics and OPENGL not in wanted:
        raise UserError(NO_OPENGL)
    about = xr.ApplicationInfo(
        application_name="subsea", engine_name="subsea", api_version=xr.Version(1, 0, 0)
    )
    instance = xr.create_instance(
        xr.InstanceCreateInfo(application_info=about, enabled_extension_names=sorted(wanted))
    )
    made.callback(destroy, xr, xr.destroy_instance, instance)
    return instance, wanted


def find_system(xr: Any, instance: Any) -> Any:
    """The headset that is connected."""
    head = xr.FormFactor.HEAD_MOUNTED_DISPLAY
    return xr.get_system(instance, xr.SystemGetInfo(form_factor=head))


def name_runtime(xr: Any, instance: Any, version: bool = False) -> str:
    """The name of the runtime, with its version if asked for."""
    known = xr.get_instance_properties(instance)
    name = _text(known.runtime_name)
    if not version:
        return name
    number = known.runtime_version
    return f"{name} {number.major}.{number.minor}.{number.patch}"


def name_system(xr: Any, instance: Any, system: Any) -> str:
    """The name of a headset."""
    return _text(xr.get_system_properties(instance, system).system_name)


def graphics_binding(xr: Any, instance: Any, system: Any) -> tuple[Any, Callable[[], object]]:
    """Describe the current OpenGL context to the runtime.

    The second value makes it current again: some runtimes change it while they open a session.
    """
    xr.get_opengl_graphics_requirements_khr(instance, system)  # OpenXR insists on the call
    if sys.platform == "win32":
        from OpenGL import WGL

        device, context = WGL.wglGetCurrentDC(), WGL.wglGetCurrentContext()
        binding = xr.GraphicsBindingOpenGLWin32KHR(h_dc=device, h_glrc=context)
        return binding, lambda: WGL.wglMakeCurrent(device, context)
    from OpenGL import GLX

    display, drawable = GLX.glXGetCurrentDisplay(), GLX.glXGetCurrentDrawable()
    context = GLX.glXGetCurrentContext()
    if not context:
        raise UserError(NO_CONTEXT)
    binding = xr.GraphicsBindingOpenGLXlibKHR(
        x_display=display, glx_drawable=drawable, glx_context=context
    )
    return binding, lambda: GLX.glXMakeCurrent(display, drawable, context)


def destroy(xr: Any, function: Callable[[Any], None], handle: Any) -> None:
    """Destroy what the handle stands for with its function of `xr`."""
    with suppress(xr.XrException):  # the runtime that had it is lost
        function(handle)


def first_line(fault: Exception) -> str:
    """The first line of an error, as the end of a sentence."""
    lines = str(fault).strip().splitlines()
    return lines[0].rstrip(". ") if lines else type(fault).__name__


def _text(value: bytes | str) -> str:
    return value.decode(errors="replace") if isinstance(value, bytes) else value
