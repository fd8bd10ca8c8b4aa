"""A session of the headset that the OpenXR runtime of this machine serves."""

import ctypes
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any, NamedTuple

from subsea.base.errors import UserError
from subsea.base.system import require
from subsea.stage.headset import controllers
from subsea.stage.headset.head import AT_REST, HeadEye, Pose

OPENGL = "XR_KHR_opengl_enable"
NO_RUNTIME = (
    "no OpenXR runtime: install the software of the headset, SteamVR or Monado, and make it the "
    "active OpenXR runtime in its settings"
)
NOT_RUNNING = "the OpenXR runtime does not start: start the software of the headset, then try again"
NO_HEADSET = "no headset: connect it, switch it on and start its software"
NO_OPENGL = "the OpenXR runtime does not support OpenGL: make SteamVR or Monado the active one"
NO_CONTEXT = "OpenXR needs a window on X11: unset WAYLAND_DISPLAY, or set it to nothing"
FORMATS = 0x8C43, 0x8058  # SRGB8_ALPHA8, RGBA8: the best first
CLOSING_S = 2.0  # for the runtime to let a session end
ENDED = "the software of the headset ended the dive"
LOST = "the headset was lost"


class HeadsetReport(NamedTuple):
    """The runtime and the headset of this machine, for people."""

    runtime: str = ""  # name and version; empty if there is none
    headset: str = ""  # its name; empty if there is none
    missing: str = ""  # one line: the first thing that a dive in a headset lacks here


class _Swapchain(NamedTuple):
    """The pictures of one eye that the runtime shows in turn."""

    handle: Any
    size: tuple[int, int]  # pixels
    textures: tuple[int, ...]  # their names in OpenGL


def open_headset() -> "OpenXrHeadset":
    """Open a session that draws with the OpenGL context which is current in this thread.

    A UserError says in one line what is missing.
    """
    xr = _library()
    with opening(xr), ExitStack() as made:
        instance, extensions = make_instance(xr, made, graphics=True)
        system = find_system(xr, instance)
        return OpenXrHeadset(xr, instance, system, extensions, made)


def describe_headset() -> HeadsetReport:
    """Describe the runtime and the headset; needs no OpenGL context and raises no UserError."""
    runtime = headset = missing = ""
    try:
        xr = _library()
        with opening(xr), ExitStack() as made:
            instance, extensions = make_instance(xr, made, graphics=False)
            runtime = name_runtime(xr, instance, version=True)
            headset = name_system(xr, instance, find_system(xr, instance))
            missing = "" if OPENGL in extensions else NO_OPENGL
    except UserError as fault:
        missing = str(fault)
    return HeadsetReport(runtime, headset, missing)


class OpenXrHeadset:
    """The session of a headset, in the OpenGL context that is current; `open_headset` makes it.

    Every call may raise HeadsetLostError. While no picture is visible its frames have no textures.
    """

    name: str  # of the runtime and of the headset, for people
    sizes: tuple[tuple[int, int], ...]  # of the pictures, pixels, left and right
    srgb: bool  # the textures hold values of sRGB, as a window does; False: linear ones
    hands: tuple[controllers.Hand, controllers.Hand]  # left and right, as of the last `poll`
    worn: bool  # True while the runtime shows the dive: from VISIBLE on
    focused: bool  # True while it takes input
    # True if the runtime asks to take the head in the last `begin` as home: in the first frame of
    # a new space whose head is tracked.
    recentred: bool

    def __init__(
        self, xr: Any, instance: Any, system: Any, extensions: set[str], made: ExitStack
    ) -> None:
        """Make the session and its parts; `made`, which destroys them, is the headset's then."""
        self._xr, self._instance = xr, instance
        self.name = f"{name_runtime(xr, instance)}: {name_system(xr, instance, system)}"
        self.state = "UNKNOWN"  # of the session, as OpenXR calls it
        self.hands = controllers.NO_HANDS
        self.worn = self.focused = self.recentred = False
        self._views = xr.ViewConfigurationType.PRIMARY_STEREO
        binding, restore = graphics_binding(xr, instance, system)
        info = xr.SessionCreateInfo(system_id=system, next=binding)
        self._session = xr.create_session(instance, info)
        made.callback(destroy, xr, xr.destroy_session, self._session)
        local = xr.ReferenceSpaceCreateInfo(reference_space_type=xr.ReferenceSpaceType.LOCAL)
        self._space = xr.create_reference_space(self._session, local)
        self._controllers = controllers.Controllers(xr, instance, self._session, extensions)
        self._swapchains = self._make_swapchains(system)
        modes = xr.enumerate_environment_blend_modes(instance, system, self._views)
        opaque = xr.EnvironmentBlendMode.OPAQUE
        self._blend_mode = opaque if opaque in list(modes) else modes[0]
        restore()
        self._made = made.pop_all()
        self.sizes = tuple(chain.size for chain in self._swapchains)
        self._running = False  # from READY to STOPPING
        self._waited = False  # for a frame that has not begun
        self._begun = False  # a frame that has not ended
        self._acquired: list[_Swapchain] = []
        self._lost = ""  # the reason
        self._recentre_at: int | None = None  # when the space changes, ns
        self._display_time = 0  # of the last frame, ns
        self._coming_time = 0  # of the frame after it, about
        self._eyes: tuple[HeadEye, ...] = AT_REST
        self._located = False  # the eyes are not those at rest

    def _make_swapchains(self, system: Any) -> list[_Swapchain]:
        xr = self._xr
        offered = list(xr.enumerate_swapchain_formats(self._session))
        chosen = next((known for known in FORMATS if known in offered), None)
        self.srgb = chosen == FORMATS[0]
        if chosen is None:
            raise UserError("the headset takes no pictures of 8 bits with sRGB or RGBA")
        use = xr.SwapchainUsageFlags
        chains = []
        for view in xr.enumerate_view_configuration_views(self._instance, system, self._views):
            size = view.recommended_image_rect_width, view.recommended_image_rect_height
            info = xr.SwapchainCreateInfo(
                usage_flags=use.COLOR_ATTACHMENT_BIT | use.SAMPLED_BIT,
                format=chosen,
                sample_count=1,  # the dive smooths edges itself
                width=size[0],
                height=size[1],
                face_count=1,
                array_size=1,
                mip_count=1,
            )
            handle = xr.create_swapchain(self._session, info)
            images = xr.enumerate_swapchain_images(handle, xr.SwapchainImageOpenGLKHR)
            chains.append(_Swapchain(handle, size, tuple(int(image.image) for image in images)))
        return chains

    def poll(self) -> None:
        """Process events and read the hands; call once a picture."""
        with self._speaking():
            self._process_events()
            self.hands = controllers.NO_HANDS
            if self.focused and not self._lost:
                self.hands = self._controllers.read(self._space, self._coming_time)

    def _process_events(self) -> None:
        xr, kinds = self._xr, self._xr.StructureType
        while True:
            try:
                event = xr.poll_event(self._instance)
            except xr.EventUnavailable:
                return
            if event.type == kinds.EVENT_DATA_SESSION_STATE_CHANGED:
                self._enter(xr.EventDataSessionStateChanged.from_buffer(event).state)
            elif event.type == kinds.EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING:
                change = xr.EventDataReferenceSpaceChangePending.from_buffer(event)
                if change.reference_space_type == xr.ReferenceSpaceType.LOCAL:
                    self._recentre_at = int(change.change_time)
            elif event.type == kinds.EVENT_DATA_INSTANCE_LOSS_PENDING:
                self._lost = LOST

    def _enter(self, state: Any) -> None:
        xr, states = self._xr, self._xr.SessionState
        self.state = state.name
        self.worn = state in (states.VISIBLE, states.FOCUSED)
        self.focused = state == states.FOCUSED
        if state == states.READY:
            info = xr.SessionBeginInfo(primary_view_configuration_type=self._views)
            xr.begin_session(self._session, info)
            self._running = True
        elif state == states.STOPPING:
            self._running = False
            xr.end_session(self._session)
        elif state == states.EXITING:
            self._lost = ENDED
        elif state == states.LOSS_PENDING:
            self._lost = LOST

    def begin(self) -> controllers.HeadsetFrame | None:
        """Wait for the runtime and begin a frame; None, at once, while the session does not run."""
        with self._speaking():
            if not self._running:
                return None
            shown = self._begin_frame()
            tracked = self._locate()
            self.recentred = (
                tracked
                and self._recentre_at is not None
                and self._display_time >= self._recentre_at
            )
            if self.recentred:
                self._recentre_at = None
            visible = shown and self._located
            textures = [self._acquire(chain) for chain in self._swapchains] if visible else []
            return controllers.HeadsetFrame(self._eyes, tracked, visible, tuple(textures))

    def _begin_frame(self) -> bool:
        """Begin a frame; True if the runtime shows it."""
        xr, shown = self._xr, False
        if not self._waited:  # else, after an interruption, the runtime would wait for ever
            state = xr.wait_frame(self._session, xr.FrameWaitInfo())
            self._waited, shown = True, bool(state.should_render)
            self._display_time = int(state.predicted_display_time)
            self._coming_time = self._display_time + int(state.predicted_display_period)
        with suppress(xr.FrameDiscarded):  # the frame before was never shown, this one begins
            xr.begin_frame(self._session, xr.FrameBeginInfo())
        self._waited, self._begun = False, True
        return shown

    def _locate(self) -> bool:
        """Update what the runtime knows of the eyes; True if it knows all."""
        xr, flags = self._xr, self._xr.ViewStateFlags
        info = xr.ViewLocateInfo(
            view_configuration_type=self._views,
            display_time=self._display_time,
            space=self._space,
        )
        state, views = xr.locate_views(self._session, info)
        placed = bool(state.view_state_flags & flags.POSITION_VALID_BIT)
        turned = bool(state.view_state_flags & flags.ORIENTATION_VALID_BIT)
        if placed or turned:
            self._eyes = tuple(
                _updated(eye, view, placed, turned)
                for eye, view in zip(self._eyes, views, strict=True)
            )
        self._located |= turned  # a head that only turns is fine in a seat
        return placed and turned

    def _acquire(self, chain: _Swapchain) -> int:
        xr = self._xr
        number = xr.acquire_swapchain_image(chain.handle, xr.SwapchainImageAcquireInfo())
        self._acquired.append(chain)
        wait = xr.SwapchainImageWaitInfo(timeout=xr.INFINITE_DURATION)
        xr.wait_swapchain_image(chain.handle, wait)
        return chain.textures[number]

    def end(self) -> None:
        """Show the frame that `begin` returned; call it for each."""
        with self._speaking():
            self._end_frame(show=len(self._acquired) == len(self._swapchains))

    def _end_frame(self, show: bool) -> None:
        xr = self._xr
        while self._acquired:
            chain = self._acquired.pop(0)
            xr.release_swapchain_image(chain.handle, xr.SwapchainImageReleaseInfo())
        layers = []
        if show:
            views = [
                _layer_view(xr, eye, chain)
                for eye, chain in zip(self._eyes, self._swapchains, strict=True)
            ]
            layer = xr.CompositionLayerProjection(space=self._space, views=views)
            layers.append(ctypes.byref(layer))
        info = xr.FrameEndInfo(
            display_time=self._display_time,
            environment_blend_mode=self._blend_mode,
            layers=layers,
        )
        self._begun = False
        xr.end_frame(self._session, info)

    def pulse(self, hand: int, strength: float, seconds: float) -> None:
        """Vibrate the controller in a hand (0 left, 1 right), with a strength in [0, 1]."""
        with self._speaking():
            if self.focused and strength > 0.0:
                self._controllers.pulse(hand, strength, seconds)

    def close(self) -> None:
        """End the session and release everything; again, or after a loss, is fine."""
        with suppress(UserError, self._xr.XrException):
            if not self._lost:
                self._leave()
        self._lost = self._lost or ENDED
        self._running = self.worn = self.focused = False
        self.hands = controllers.NO_HANDS
        self._made.close()

    def _leave(self) -> None:
        """Ask the runtime to end the session, and serve it until it has."""
        if self._begun:  # drawing failed
            self._end_frame(show=False)
        if not self._running:
            return
        self._xr.request_exit_session(self._session)
        deadline = time.monotonic() + CLOSING_S
        while not self._lost and time.monotonic() < deadline:
            self._process_events()
            if self._running:  # else it might wait for a frame
                self._begin_frame()
                self._end_frame(show=False)
            else:
                time.sleep(0.002)

    @contextmanager
    def _speaking(self) -> Iterator[None]:
        """Turn what the runtime reports into a HeadsetLostError, now and in later calls."""
        if self._lost:
            raise controllers.HeadsetLostError(self._lost)
        try:
            yield
        except (self._xr.InstanceLostError, self._xr.SessionLostError) as fault:
            self._lost = f"{LOST}: its software ended"
            raise controllers.HeadsetLostError(self._lost) from fault
        except self._xr.XrException as fault:
            self._lost = f"{LOST}: {first_line(fault)}"
            raise controllers.HeadsetLostError(self._lost) from fault
        finally:
            if self._lost:
                self.worn = self.focused = False
                self.hands = controllers.NO_HANDS
        if self._lost:
            raise controllers.HeadsetLostError(self._lost)


def _library() -> Any:
    require("headset", "a headset")
    # The loader of OpenXR would print several lines for each error.
    os.environ.setdefault("XR_LOADER_DEBUG", "none")
    try:
        import xr
    except (ImportError, OSError, NotImplementedError) as fault:
        raise UserError(f"pyopenxr does not work here: {first_line(fault)}") from fault
    return xr


def _updated(eye: HeadEye, view: Any, placed: bool, turned: bool) -> HeadEye:
    """An eye with the valid parts of its view."""
    pose, fov = controllers.pose_of(view.pose), view.fov
    return HeadEye(
        Pose(
            pose.position if placed else eye.pose.position,
            pose.orientation if turned else eye.pose.orientation,
        ),
        fov.angle_left, fov.angle_right, fov.angle_up, fov.angle_down,
    )  # fmt: skip


def _layer_view(xr: Any, eye: HeadEye, chain: _Swapchain) -> Any:
    size = xr.Extent2Di(*chain.size)
    return xr.CompositionLayerProjectionView(
        pose=xr.Posef(
            orientation=xr.Quaternionf(*eye.pose.orientation.tolist()),
            position=xr.Vector3f(*eye.pose.position.tolist()),
        ),
        fov=xr.Fovf(eye.left, eye.right, eye.up, eye.down),
        sub_image=xr.SwapchainSubImage(
            swapchain=chain.handle, image_rect=xr.Rect2Di(xr.Offset2Di(0, 0), size)
        ),
    )


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
    properties = xr.enumerate_instance_extension_properties()
    offered = {_text(extension.extension_name) for extension in properties}
    wanted = {OPENGL, controllers.HAND_INTERACTION} & offered
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
