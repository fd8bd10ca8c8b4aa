"""A fake of pyopenxr: a runtime whose states, frames and faults a test scripts.

It checks the rules of OpenXR that a runtime checks: a call at the wrong time, a part that a
controller lacks or an unknown field of a structure is an AssertionError.
"""

import ctypes
import enum
import importlib.machinery
import sys
from collections import deque
from types import SimpleNamespace

LEFT, RIGHT = "/user/hand/left", "/user/hand/right"
PERIOD = 11_111_111  # ns
SIZES = (640, 700), (600, 720)
# Asymmetric and different for each eye, so that swapped eyes are noticed: left, right, up, down.
ANGLES = (-0.9, 0.7, 0.8, -0.85), (-0.65, 0.95, 0.75, -0.8)
SYMMETRIC = {"input/aim/pose": "pose", "input/grip/pose": "pose", "output/haptic": "haptic"}
# From the specification: the parts of both hands, then those of the left and the right one.
PARTS = {
    "khr/simple_controller": (
        {**SYMMETRIC, "input/select/click": "bool", "input/menu/click": "bool"}, {}, {},
    ),
    "oculus/touch_controller": (
        {
            **SYMMETRIC, "input/squeeze/value": "float", "input/trigger/value": "float",
            "input/trigger/touch": "bool", "input/thumbstick": "vector",
            "input/thumbstick/click": "bool",
        },
        {"input/x/click": "bool", "input/y/click": "bool", "input/menu/click": "bool"},
        {"input/a/click": "bool", "input/b/click": "bool", "input/system/click": "bool"},
    ),
    "valve/index_controller": (
        {
            **SYMMETRIC, "input/system/click": "bool", "input/a/click": "bool",
            "input/b/click": "bool", "input/squeeze/value": "float", "input/squeeze/force": "float",
            "input/trigger/click": "bool", "input/trigger/value": "float",
            "input/thumbstick": "vector", "input/thumbstick/click": "bool",
            "input/trackpad": "vector", "input/trackpad/force": "float",
        },
        {}, {},
    ),
    "htc/vive_controller": (
        {
            **SYMMETRIC, "input/system/click": "bool", "input/squeeze/click": "bool",
            "input/menu/click": "bool", "input/trigger/click": "bool",
            "input/trigger/value": "float", "input/trackpad": "vector",
            "input/trackpad/click": "bool", "input/trackpad/touch": "bool",
        },
        {}, {},
    ),
    "microsoft/motion_controller": (
        {
            **SYMMETRIC, "input/menu/click": "bool", "input/squeeze/click": "bool",
            "input/trigger/value": "float", "input/thumbstick": "vector",
            "input/thumbstick/click": "bool", "input/trackpad": "vector",
            "input/trackpad/click": "bool", "input/trackpad/touch": "bool",
        },
        {}, {},
    ),
    "ext/hand_interaction_ext": (
        {
            "input/aim/pose": "pose", "input/grip/pose": "pose", "input/pinch_ext/value": "float",
            "input/aim_activate_ext/value": "float", "input/grasp_ext/value": "float",
        },
        {}, {},
    ),
}  # fmt: skip
# Kinds of parts that an action of a kind may be bound to; the runtime converts buttons.
FITTING = {"POSE_INPUT": {"pose"}, "VECTOR2F_INPUT": {"vector"}, "FLOAT_INPUT": {"float", "bool"},
           "BOOLEAN_INPUT": {"bool", "float"}, "VIBRATION_OUTPUT": {"haptic"}}  # fmt: skip


XrException = type("XrException", (Exception,), {})


ERRORS = {
    name: type(name, (XrException,), {})
    for name in (
        "EventUnavailable", "FrameDiscarded", "SessionNotFocused", "SessionLossPending",
        "RuntimeUnavailableError", "RuntimeFailureError", "InitializationFailedError",
        "FormFactorUnavailableError", "FormFactorUnsupportedError", "PathUnsupportedError",
        "InstanceLostError", "SessionLostError", "GraphicsDeviceInvalidError",
    )
}  # fmt: skip
STRUCTURES = {
    "ApplicationInfo": "application_name engine_name api_version",
    "InstanceCreateInfo": "application_info enabled_extension_names",
    "SystemGetInfo": "form_factor",
    "SessionCreateInfo": "system_id next",
    "SessionBeginInfo": "primary_view_configuration_type",
    "ReferenceSpaceCreateInfo": "reference_space_type",
    "SwapchainCreateInfo": (
        "usage_flags format sample_count width height face_count array_size mip_count"
    ),
    "SwapchainImageAcquireInfo": "",
    "SwapchainImageWaitInfo": "timeout",
    "SwapchainImageReleaseInfo": "",
    "SwapchainImageOpenGLKHR": "image",
    "FrameWaitInfo": "",
    "FrameBeginInfo": "",
    "FrameEndInfo": "display_time environment_blend_mode layers",
    "ViewLocateInfo": "view_configuration_type display_time space",
    "CompositionLayerProjection": "space views",
    "CompositionLayerProjectionView": "pose fov sub_image",
    "SwapchainSubImage": "swapchain image_rect",
    "Rect2Di": "offset extent",
    "Offset2Di": "x y",
    "Extent2Di": "width height",
    "Posef": "orientation position",
    "Quaternionf": "x y z w",
    "Vector3f": "x y z",
    "Fovf": "angle_left angle_right angle_up angle_down",
    "ActionSetCreateInfo": "action_set_name localized_action_set_name priority",
    "ActionCreateInfo": "action_name action_type subaction_paths localized_action_name",
    "ActionSuggestedBinding": "action binding",
    "InteractionProfileSuggestedBinding": "interaction_profile suggested_bindings",
    "SessionActionSetsAttachInfo": "action_sets",
    "ActionSpaceCreateInfo": "action subaction_path",
    "ActionStateGetInfo": "action subaction_path",
    "ActiveActionSet": "action_set subaction_path",
    "ActionsSyncInfo": "active_action_sets",
    "HapticVibration": "duration frequency amplitude",
    "HapticActionInfo": "action subaction_path",
    "EventDataSessionStateChanged": "type state",
    "EventDataReferenceSpaceChangePending": "type reference_space_type change_time",
    "EventDataInstanceLossPending": "type",
}
Flags = enum.IntFlag(
    "Flags",
    "ORIENTATION_VALID_BIT POSITION_VALID_BIT ORIENTATION_TRACKED_BIT POSITION_TRACKED_BIT",
)
ENUMERATIONS = {
    "FormFactor": enum.IntEnum("FormFactor", "HEAD_MOUNTED_DISPLAY HANDHELD_DISPLAY"),
    "ViewConfigurationType": enum.IntEnum("ViewConfigurationType", "PRIMARY_MONO PRIMARY_STEREO"),
    "EnvironmentBlendMode": enum.IntEnum("EnvironmentBlendMode", "OPAQUE ADDITIVE ALPHA_BLEND"),
    "ReferenceSpaceType": enum.IntEnum("ReferenceSpaceType", "VIEW LOCAL STAGE"),
    "SessionState": enum.IntEnum(
        "SessionState",
        "IDLE READY SYNCHRONIZED VISIBLE FOCUSED STOPPING LOSS_PENDING EXITING",
    ),
    "SwapchainUsageFlags": enum.IntFlag("Usage", "COLOR_ATTACHMENT_BIT SAMPLED_BIT"),
    "ActionType": enum.IntEnum("ActionType", list(FITTING)),
    "StructureType": enum.IntEnum(
        "StructureType",
        "EVENT_DATA_SESSION_STATE_CHANGED EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING "
        "EVENT_DATA_INSTANCE_LOSS_PENDING EVENT_DATA_INTERACTION_PROFILE_CHANGED",
    ),
    "ViewStateFlags": Flags,
    "SpaceLocationFlags": Flags,
}
VALID = Flags.ORIENTATION_VALID_BIT | Flags.POSITION_VALID_BIT
TRACKED = VALID | Flags.ORIENTATION_TRACKED_BIT | Flags.POSITION_TRACKED_BIT


def _structure(name, fields):
    """A structure that `ctypes.byref` takes, with these fields and no others."""

    def make(self, *values, **named):
        named |= dict(zip(fields, values, strict=False))
        assert named.keys() <= set(fields), f"{name} has no {named.keys() - set(fields)}"
        self.__dict__.update(named)

    return type(name, (ctypes.Structure,), {
        "_fields_": [], "__init__": make, "from_buffer": classmethod(lambda cls, event: event)
    })  # fmt: skip


def pose(place=(0.0, 0.0, 0.0), turn=(0.0, 0.0, 0.0, 1.0)):
    """A pose as the runtime gives it."""
    return SimpleNamespace(
        position=SimpleNamespace(**dict(zip("xyz", place, strict=True))),
        orientation=SimpleNamespace(**dict(zip("xyzw", turn, strict=True))),
    )


class FakeXr:
    """The module, its loader and a runtime with a headset, all in one."""

    INFINITE_DURATION, FREQUENCY_UNSPECIFIED = 2**63 - 1, 0
    XrException = XrException

    def __init__(self):
        self.__dict__.update(ERRORS)
        self.__dict__.update(ENUMERATIONS)
        for name, fields in STRUCTURES.items():
            setattr(self, name, _structure(name, fields.split()))
        self.Version = lambda *numbers: numbers
        self.__spec__ = importlib.machinery.ModuleSpec("xr", None)
        # The script of a test:
        self.extensions = ["XR_KHR_opengl_enable", "XR_EXT_hand_interaction"]
        self.formats = [0x8058, 0x8C43]
        self.blend_modes = [ENUMERATIONS["EnvironmentBlendMode"].OPAQUE]
        self.unknown_profiles = set()
        self.faults = {}  # names of calls, and the error that each raises
        self.renders = True
        self.view_flags = TRACKED
        self.eye_poses = [pose((-0.03, 1.0, 0.0)), pose((0.03, 1.0, 0.0))]
        self.inputs = {}  # (hand, action): value
        self.aims = {}  # hand: pose
        self.leaves = True  # a session ends if asked to
        # The record of it:
        self.calls, self.events, self.state = [], deque(), None
        self.running = self.begun = False
        self.now, self.waited, self.focused = 0, 0, False
        self.chains, self.bindings, self.pulses, self.shown = [], {}, [], []
        self.alive = set()  # instance, session

    # --- for tests ---

    def enter(self, *names):
        """Let the session enter states, each by an event."""
        kind = self.StructureType.EVENT_DATA_SESSION_STATE_CHANGED
        for name in names:
            state = self.SessionState[name]
            self.events.append(self.EventDataSessionStateChanged(type=kind, state=state))

    def recentre(self, change_time=0, space="LOCAL"):
        """Let the user recentre."""
        self.events.append(
            self.EventDataReferenceSpaceChangePending(
                type=self.StructureType.EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING,
                reference_space_type=self.ReferenceSpaceType[space],
                change_time=change_time,
            )
        )

    def lose_instance(self):
        """Announce that the runtime ends."""
        kind = self.StructureType.EVENT_DATA_INSTANCE_LOSS_PENDING
        self.events.append(self.EventDataInstanceLossPending(type=kind))

    def count(self, name):
        """The number of calls of a function."""
        return self.calls.count(name)

    def _note(self, name):
        self.calls.append(name)
        if fault := self.faults.get(name) or self.faults.get("*"):
            raise ERRORS[fault](f"{fault} of the fake.\nMore lines.")

    # --- instance and system ---

    def enumerate_instance_extension_properties(self):
        self._note("enumerate_instance_extension_properties")
        return [SimpleNamespace(extension_name=name.encode()) for name in self.extensions]

    def create_instance(self, info):
        self._note("create_instance")
        assert set(info.enabled_extension_names) <= set(self.extensions)
        self.enabled = set(info.enabled_extension_names)
        self.alive.add("instance")
        return "instance"

    def destroy_instance(self, instance):
        self._note("destroy_instance")
        assert self.alive == {"instance"}, "the session is destroyed first"
        self.alive.remove(instance)

    def get_instance_properties(self, instance):
        version = SimpleNamespace(major=2, minor=5, patch=1)
        return SimpleNamespace(runtime_name=b"Fake runtime", runtime_version=version)

    def get_system(self, instance, info):
        self._note("get_system")
        assert info.form_factor == self.FormFactor.HEAD_MOUNTED_DISPLAY
        return 7

    def get_system_properties(self, instance, system):
        return SimpleNamespace(system_name=b"Fake headset")

    def string_to_path(self, instance, text):
        return text

    # --- session ---

    def create_session(self, instance, info):
        self._note("create_session")
        assert info.system_id == 7
        assert info.next == "binding"
        self.alive.add("session")
        return "session"

    def destroy_session(self, session):
        self._note("destroy_session")
        self.alive.remove(session)

    def create_reference_space(self, session, info):
        assert info.reference_space_type == self.ReferenceSpaceType.LOCAL
        return "local"

    def enumerate_environment_blend_modes(self, instance, system, views):
        return self.blend_modes

    def enumerate_swapchain_formats(self, session):
        return self.formats

    def enumerate_view_configuration_views(self, instance, system, views):
        assert views == self.ViewConfigurationType.PRIMARY_STEREO
        return [
            SimpleNamespace(recommended_image_rect_width=width, recommended_image_rect_height=tall)
            for width, tall in SIZES
        ]

    def create_swapchain(self, session, info):
        assert info.format in self.formats
        assert (info.width, info.height) == SIZES[len(self.chains)]
        chain = SimpleNamespace(format=info.format, held=False, ready=False, next=0)
        chain.textures = [10 * (1 + len(self.chains)) + number for number in range(3)]
        self.chains.append(chain)
        return chain

    def enumerate_swapchain_images(self, chain, kind):
        return [kind(image=texture) for texture in chain.textures]

    def poll_event(self, instance):
        self._note("poll_event")
        if not self.events:
            raise ERRORS["EventUnavailable"]
        event = self.events.popleft()
        if hasattr(event, "state"):
            self.state = event.state
            self.focused = event.state == self.SessionState.FOCUSED
        return event

    def begin_session(self, session, info):
        self._note("begin_session")
        assert self.state == self.SessionState.READY
        assert not self.running
        self.running = True

    def end_session(self, session):
        self._note("end_session")
        assert self.state == self.SessionState.STOPPING
        assert self.running
        assert not self.begun, "a frame has begun"
        self.running = False
        if self.leaves:
            self.enter("IDLE", "EXITING")

    def request_exit_session(self, session):
        self._note("request_exit_session")
        assert self.running
        if self.leaves:
            self.enter("VISIBLE", "SYNCHRONIZED", "STOPPING")

    # --- frames ---

    def wait_frame(self, session, info):
        self._note("wait_frame")
        assert self.running, "the session does not run"
        assert self.waited == 0, "the frame before has not begun"
        self.waited = 1
        self.now += PERIOD
        return SimpleNamespace(
            predicted_display_time=self.now,
            predicted_display_period=PERIOD,
            should_render=int(self.renders),
        )

    def begin_frame(self, session, info):
        self.waited = 0
        discarded, self.begun = self.begun, True
        self._note("begin_frame")
        assert not discarded, "the frame before has not ended"

    def locate_views(self, session, info):
        self._note("locate_views")
        assert info.display_time == self.now
        assert info.space == "local"
        views = [
            SimpleNamespace(pose=where, fov=self.Fovf(*angles))
            for where, angles in zip(self.eye_poses, ANGLES, strict=True)
        ]
        return SimpleNamespace(view_state_flags=self.view_flags), views

    def acquire_swapchain_image(self, chain, info):
        self._note("acquire_swapchain_image")
        assert self.begun
        assert not chain.held
        chain.held, chain.next = True, (chain.next + 1) % len(chain.textures)
        return chain.next

    def wait_swapchain_image(self, chain, info):
        self._note("wait_swapchain_image")
        assert chain.held
        chain.ready = True

    def release_swapchain_image(self, chain, info):
        self._note("release_swapchain_image")
        assert chain.held
        assert chain.ready
        chain.held = chain.ready = False

    def end_frame(self, session, info):
        self._note("end_frame")
        assert self.begun
        assert not any(chain.held for chain in self.chains), "an image is not released"
        assert info.display_time == self.now
        assert info.environment_blend_mode in self.blend_modes
        self.begun = False
        layers = [layer._obj for layer in info.layers]
        for layer in layers:
            assert layer.space == "local"
            assert self.renders, "a layer of a frame that is not shown"
            for view, chain, size in zip(layer.views, self.chains, SIZES, strict=True):
                extent = view.sub_image.image_rect.extent
                assert view.sub_image.swapchain is chain
                assert (extent.width, extent.height) == size
        self.shown.append(layers)

    # --- actions ---

    def create_action_set(self, instance, info):
        assert info.action_set_name == info.action_set_name.lower()
        return "actions"

    def create_action(self, actions, info):
        assert info.subaction_paths == [LEFT, RIGHT]
        return SimpleNamespace(name=info.action_name, kind=info.action_type)

    def suggest_interaction_profile_bindings(self, instance, suggested):
        assert self.count("attach_session_action_sets") == 0
        name = suggested.interaction_profile.removeprefix("/interaction_profiles/")
        if name in self.unknown_profiles:
            raise ERRORS["PathUnsupportedError"]
        assert "hand_interaction" not in name or "XR_EXT_hand_interaction" in self.enabled
        both, left, right = PARTS[name]
        offered = {f"{hand}/{part}": kind
                   for hand, own in ((LEFT, left), (RIGHT, right))
                   for part, kind in (both | own).items()}  # fmt: skip
        for one in suggested.suggested_bindings:
            assert offered[one.binding] in FITTING[one.action.kind.name], one.binding
        self.bindings[name] = {
            (one.action.name, one.binding) for one in suggested.suggested_bindings
        }

    def attach_session_action_sets(self, session, info):
        self._note("attach_session_action_sets")
        assert info.action_sets == ["actions"]

    def create_action_space(self, session, info):
        assert info.action.name == "aim"
        return info.subaction_path

    def sync_actions(self, session, info):
        self._note("sync_actions")
        assert self.count("attach_session_action_sets") == 1
        if not self.focused:
            raise ERRORS["SessionNotFocused"]

    def _read(self, info, kinds, default):
        assert info.action.kind.name in kinds
        value = self.inputs.get((info.subaction_path, info.action.name), default)
        active = (info.subaction_path, info.action.name) in self.inputs
        return SimpleNamespace(current_state=value, is_active=int(active))

    def get_action_state_boolean(self, session, info):
        return self._read(info, {"BOOLEAN_INPUT"}, 0)

    def get_action_state_float(self, session, info):
        return self._read(info, {"FLOAT_INPUT"}, 0.0)

    def get_action_state_vector2f(self, session, info):
        return self._read(info, {"VECTOR2F_INPUT"}, SimpleNamespace(x=0.0, y=0.0))

    def locate_space(self, hand, space, time):
        assert space == "local"
        assert time > 0, "not a time of the runtime"
        found = self.aims.get(hand)
        return SimpleNamespace(location_flags=TRACKED if found else Flags(0), pose=found or pose())

    def apply_haptic_feedback(self, session, info, vibration):
        self._note("apply_haptic_feedback")
        assert info.action.kind == self.ActionType.VIBRATION_OUTPUT
        assert 0.0 <= vibration.amplitude <= 1.0
        assert vibration.duration > 0
        self.pulses.append((info.subaction_path, vibration.amplitude, vibration.duration))


def install(monkeypatch):
    """Put a new fake in place of pyopenxr and of the OpenGL context."""
    from subsea.stage.headset import openxr

    fake = FakeXr()
    monkeypatch.setitem(sys.modules, "xr", fake)
    monkeypatch.setattr(openxr, "graphics_binding", lambda *_: ("binding", lambda: None))
    return fake
