"""The session of a headset against a fake runtime that checks the order of calls."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.cli import doctor as doctor_command
from subsea.cli.main import main
from subsea.stage.headset.controllers import PROFILES, Hand, HeadsetLostError
from subsea.stage.headset.openxr import HeadsetReport, describe_headset, open_headset
from tests.stage.headset.fake_xr import ANGLES, LEFT, PARTS, RIGHT, SIZES, Flags, install, pose

TO_FOCUS = "IDLE", "READY", "SYNCHRONIZED", "VISIBLE", "FOCUSED"
FROM_FOCUS = "VISIBLE", "SYNCHRONIZED", "STOPPING"
QUARTER = (0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5))


@pytest.fixture
def xr(monkeypatch):
    return install(monkeypatch)


@pytest.fixture
def headset(xr):
    opened = open_headset()
    yield opened
    opened.close()
    assert not xr.alive


@pytest.fixture
def focused(xr, headset):
    """A headset with the focus, one frame later."""
    xr.enter(*TO_FOCUS)
    headset.poll()
    headset.begin()
    headset.end()
    return headset


def one_line(fault):
    text = str(fault.value)
    assert text
    return text


# --- life cycle ---


def test_a_session_says_its_names_and_sizes(headset):
    assert headset.name == "Fake runtime: Fake headset"
    assert headset.sizes == SIZES
    assert headset.hands == (Hand(), Hand())
    assert not (headset.worn or headset.focused or headset.recentred)


def test_no_frame_begins_until_the_session_runs(xr, headset):
    headset.poll()
    assert headset.begin() is None
    xr.enter("IDLE")
    headset.poll()
    assert headset.begin() is None
    assert xr.count("wait_frame") == 0
    xr.enter("READY")
    headset.poll()
    assert headset.begin() is not None
    headset.end()


@pytest.mark.parametrize(
    ("state", "worn", "focused"),
    [("READY", False, False), ("SYNCHRONIZED", False, False), ("VISIBLE", True, False),
     ("FOCUSED", True, True)],
)  # fmt: skip
def test_worn_and_focused_follow_the_state(xr, headset, state, worn, focused):
    xr.enter(*TO_FOCUS[: TO_FOCUS.index(state) + 1])
    headset.poll()
    assert (headset.state, headset.worn, headset.focused) == (state, worn, focused)


def test_a_frame_makes_its_calls_in_order(xr, focused):
    xr.calls.clear()
    frame = focused.begin()
    assert frame.visible
    assert frame.tracked
    assert [texture // 10 for texture in frame.textures] == [1, 2]  # left and right
    focused.end()
    assert xr.calls == [
        "wait_frame", "begin_frame", "locate_views",
        "acquire_swapchain_image", "wait_swapchain_image",
        "acquire_swapchain_image", "wait_swapchain_image",
        "release_swapchain_image", "release_swapchain_image", "end_frame",
    ]  # fmt: skip


def test_textures_take_turns(focused):
    seen = []
    for _ in range(4):
        seen.append(focused.begin().textures)
        focused.end()
    assert len(set(seen)) == 3
    assert seen[0] == seen[3]


def test_eyes_have_their_own_poses_and_angles(xr, focused):
    frame = focused.begin()
    focused.end()
    for eye, angles, x in zip(frame.eyes, ANGLES, (-0.03, 0.03), strict=True):
        assert (eye.left, eye.right, eye.up, eye.down) == angles
        np.testing.assert_array_equal(eye.pose.position, [x, 1.0, 0.0])
        np.testing.assert_array_equal(eye.pose.orientation, [0.0, 0.0, 0.0, 1.0])
    [layer] = xr.shown[-1]
    for view, angles, x in zip(layer.views, ANGLES, (-0.03, 0.03), strict=True):
        assert (view.fov.angle_left, view.fov.angle_right) == angles[:2]
        assert (view.fov.angle_up, view.fov.angle_down) == angles[2:]
        assert (view.pose.position.x, view.pose.position.y) == (x, 1.0)


def test_a_frame_that_is_not_shown_has_no_textures_and_no_layer(xr, focused):
    xr.renders = False
    frame = focused.begin()
    focused.end()
    assert not frame.visible
    assert frame.textures == ()
    assert len(frame.eyes) == 2
    assert xr.shown[-1] == []


def test_a_discarded_frame_is_a_frame(xr, focused):
    xr.faults["begin_frame"] = "FrameDiscarded"
    assert focused.begin().visible
    focused.end()


def test_a_session_stops_and_runs_again(xr, focused):
    xr.leaves = False
    xr.enter(*FROM_FOCUS, "IDLE")
    focused.poll()
    assert xr.count("end_session") == 1
    assert focused.begin() is None
    xr.enter(*TO_FOCUS[1:])
    focused.poll()
    assert focused.focused
    assert focused.begin().visible
    focused.end()


def test_close_lets_the_session_end(xr, focused):
    focused.close()
    assert xr.count("request_exit_session") == xr.count("end_session") == 1
    assert focused.state == "EXITING"
    assert not (focused.worn or focused.focused)
    calls = len(xr.calls)
    focused.close()
    assert len(xr.calls) == calls
    with pytest.raises(HeadsetLostError):
        focused.begin()


def test_close_in_the_middle_of_a_frame_ends_it_without_a_layer(xr, focused):
    focused.begin()
    focused.close()
    assert xr.shown[-1] == []
    assert xr.count("acquire_swapchain_image") == xr.count("release_swapchain_image")
    assert xr.count("begin_frame") == xr.count("end_frame")


def test_close_after_an_interruption_between_wait_and_begin(xr, focused, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(xr, "begin_frame", interrupted)
        with pytest.raises(KeyboardInterrupt):
            focused.begin()
    monkeypatch.setattr("subsea.stage.headset.openxr.CLOSING_S", 0.01)
    xr.leaves = False  # so that closing serves frames
    focused.close()
    assert xr.count("wait_frame") == xr.count("begin_frame") == xr.count("end_frame")


def test_close_does_not_wait_for_ever(xr, focused, monkeypatch):
    monkeypatch.setattr("subsea.stage.headset.openxr.CLOSING_S", 0.05)
    xr.leaves = False
    focused.close()
    assert not xr.alive


# --- losses ---


@pytest.mark.parametrize("state", ["EXITING", "LOSS_PENDING"])
def test_a_session_that_the_runtime_ends_is_lost_for_good(xr, focused, state):
    xr.enter(state)
    for call in (focused.poll, focused.begin, focused.end, lambda: focused.pulse(0, 1.0, 0.1)):
        with pytest.raises(HeadsetLostError) as fault:
            call()
        assert one_line(fault)
    assert not (focused.worn or focused.focused)


def test_an_instance_that_is_about_to_be_lost_is_lost(xr, focused):
    xr.lose_instance()
    with pytest.raises(HeadsetLostError) as fault:
        focused.poll()
    one_line(fault)


@pytest.mark.parametrize(
    "error", ["InstanceLostError", "SessionLostError", "SessionLossPending", "RuntimeFailureError"]
)
@pytest.mark.parametrize(
    ("call", "method"),
    [
        ("poll_event", "poll"), ("sync_actions", "poll"), ("wait_frame", "begin"),
        ("begin_frame", "begin"), ("locate_views", "begin"), ("acquire_swapchain_image", "begin"),
        ("wait_swapchain_image", "begin"), ("release_swapchain_image", "end"), ("end_frame", "end"),
    ],
)  # fmt: skip
def test_a_loss_in_any_call_is_one_line(xr, focused, call, method, error):
    if method == "end":
        focused.begin()
    xr.faults[call] = error
    with pytest.raises(HeadsetLostError) as fault:
        getattr(focused, method)()
    assert one_line(fault).startswith("the headset was lost: ")
    xr.calls.clear()
    focused.close()
    assert xr.calls == ["destroy_session", "destroy_instance"]


def test_close_is_quiet_while_everything_fails(xr, headset):
    xr.enter(*TO_FOCUS)
    headset.poll()
    headset.begin()
    xr.faults["*"] = "InstanceLostError"
    headset.close()
    xr.alive.clear()


# --- opening ---


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        ("enumerate_instance_extension_properties", "RuntimeUnavailableError", "no OpenXR runtime"),
        ("create_instance", "RuntimeUnavailableError", "no OpenXR runtime"),
        ("create_instance", "RuntimeFailureError", "does not start"),
        ("get_system", "FormFactorUnavailableError", "no headset"),
        ("get_system", "FormFactorUnsupportedError", "no headset"),
        ("create_session", "GraphicsDeviceInvalidError", "does not open: GraphicsDeviceInvalid"),
    ],
)
def test_a_headset_that_does_not_open_says_why(xr, call, error, text):
    xr.faults[call] = error
    with pytest.raises(UserError) as fault:
        open_headset()
    assert text in one_line(fault)
    assert not xr.alive


@pytest.mark.parametrize(
    ("lacks", "left", "text"),
    [("extensions", [], "does not support OpenGL"), ("formats", [0x881A], "pictures")],
)
def test_a_runtime_that_lacks_something_says_what(xr, lacks, left, text):
    setattr(xr, lacks, left)
    with pytest.raises(UserError) as fault:
        open_headset()
    assert text in one_line(fault)
    assert not xr.alive


@pytest.mark.parametrize(("formats", "srgb"), [([0x8058], False), ([0x8058, 0x8C43], True)])
def test_pictures_are_srgb_if_the_runtime_takes_it(xr, formats, srgb):
    xr.formats = formats
    headset = open_headset()
    assert headset.srgb == srgb
    headset.close()


def test_without_the_package_its_installation_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "xr", None)
    with pytest.raises(UserError, match="a headset needs pyopenxr: run `"):
        open_headset()


def test_a_see_through_display_draws_as_it_can(xr):
    xr.blend_modes = [xr.EnvironmentBlendMode.ADDITIVE]
    xr.enter(*TO_FOCUS)
    headset = open_headset()
    headset.poll()
    headset.begin()
    headset.end()
    headset.close()


# --- tracking ---


def test_a_head_that_is_not_tracked_keeps_its_last_pose(xr, focused):
    xr.view_flags = Flags(0)
    xr.eye_poses = [pose((9.0, 9.0, 9.0), (0.0, 0.0, 0.0, 0.0))] * 2
    frame = focused.begin()
    focused.end()
    assert not frame.tracked
    assert frame.visible
    np.testing.assert_array_equal(frame.eyes[0].pose.position, [-0.03, 1.0, 0.0])
    np.testing.assert_array_equal(frame.eyes[0].pose.orientation, [0.0, 0.0, 0.0, 1.0])


def test_a_head_without_a_place_still_turns(xr, focused):
    xr.view_flags = Flags.ORIENTATION_VALID_BIT
    xr.eye_poses = [pose((9.0, 9.0, 9.0), QUARTER)] * 2
    frame = focused.begin()
    focused.end()
    assert not frame.tracked
    np.testing.assert_array_equal(frame.eyes[1].pose.position, [0.03, 1.0, 0.0])
    np.testing.assert_array_equal(frame.eyes[1].pose.orientation, QUARTER)


def test_a_head_that_was_never_found_is_not_drawn(xr, headset):
    xr.view_flags = Flags(0)
    xr.enter(*TO_FOCUS)
    headset.poll()
    frame = headset.begin()
    headset.end()
    assert not frame.visible
    assert frame.eyes[0].pose.position[0] < 0.0 < frame.eyes[1].pose.position[0]
    assert xr.shown == [[]]
    xr.view_flags = Flags.ORIENTATION_VALID_BIT | Flags.POSITION_VALID_BIT
    assert headset.begin().visible
    headset.end()


def test_a_pose_that_jumps_arrives(xr, focused):
    xr.eye_poses = [pose((5.0, 1.0, 0.0)), pose((5.06, 1.0, 0.0))]
    assert focused.begin().eyes[0].pose.position[0] == 5.0
    focused.end()


# --- recentring ---


def frames_until_recentred(headset, most=5):
    for number in range(1, most + 1):
        headset.poll()
        headset.begin()
        headset.end()
        if headset.recentred:
            return number
    return None


@pytest.mark.parametrize(
    ("later_ns", "space", "frames"), [(0, "LOCAL", 1), (25_000_000, "LOCAL", 3), (0, "STAGE", None)]
)
def test_the_runtime_recentres_once_at_its_time(xr, focused, later_ns, space, frames):
    """A change of another space is ignored."""
    xr.recentre(change_time=xr.now + later_ns, space=space)
    assert frames_until_recentred(focused) == frames
    assert frames_until_recentred(focused) is None


def test_recentring_waits_for_a_tracked_head(xr, focused):
    flags, xr.view_flags = xr.view_flags, Flags(0)
    xr.recentre()
    assert frames_until_recentred(focused) is None
    xr.view_flags = flags
    assert frames_until_recentred(focused) == 1


# --- hands ---


def test_every_profile_is_suggested(xr, headset):
    assert xr.bindings.keys() == PARTS.keys() == PROFILES.keys()


@pytest.mark.parametrize("name", PARTS)
def test_each_profile_binds_both_hands_and_its_main_actions(xr, headset, name):
    bound = xr.bindings[name]
    for hand in (LEFT, RIGHT):
        actions = {action for action, path in bound if path.startswith(hand)}
        assert {"aim", "trigger"} <= actions
        assert "haptic" in actions or "hand_interaction" in name
        assert "stick" in actions or "simple" in name or "hand_interaction" in name


@pytest.mark.parametrize("name", PARTS)
def test_every_controller_has_the_menu_and_food(xr, headset, name):
    bound = dict(xr.bindings[name])
    if "hand_interaction" in name:  # by its fists
        assert "menu" not in bound and "squeeze" in bound
    else:
        assert bound["menu"].startswith(LEFT) and bound["feed"].startswith(RIGHT)


def test_two_actions_of_a_controller_never_share_a_part(xr, headset):
    for bound in xr.bindings.values():
        paths = [path for _, path in bound]
        assert len(paths) == len(set(paths))


def test_profiles_that_the_runtime_lacks_are_left_out(xr):
    xr.extensions = ["XR_KHR_opengl_enable"]
    xr.unknown_profiles = {"htc/vive_controller"}
    headset = open_headset()
    assert PARTS.keys() - xr.bindings.keys() == {"htc/vive_controller", "ext/hand_interaction_ext"}
    headset.close()


def test_hands_are_read_by_poll(xr, focused):
    xr.aims[RIGHT] = pose((0.2, 0.9, -0.4), QUARTER)
    xr.inputs = {
        (LEFT, "stick"): pose((-0.5, 1.0, 0.0)).position, (LEFT, "trigger"): 0.25,
        (RIGHT, "squeeze"): 1.0, (RIGHT, "primary"): 1, (LEFT, "secondary"): 1, (LEFT, "menu"): 1,
        (RIGHT, "feed"): 1,
    }  # fmt: skip
    focused.poll()
    left, right = focused.hands
    assert left == Hand(None, (-0.5, 1.0), 0.25, 0.0, False, True, True)
    assert right[1:] == (None, 0.0, 1.0, True, False, False, True)
    np.testing.assert_array_equal(right.aim.position, [0.2, 0.9, -0.4])
    np.testing.assert_array_equal(right.aim.orientation, QUARTER)


def test_before_the_first_frame_hands_have_no_place(xr, headset):
    xr.aims[LEFT] = pose()
    xr.enter(*TO_FOCUS)
    headset.poll()
    assert headset.hands[0].aim is None


def test_hands_are_at_rest_without_the_focus(xr, focused):
    xr.inputs = {(LEFT, "trigger"): 1.0}
    focused.poll()
    assert focused.hands[0].trigger == 1.0
    xr.focused = False  # the event that says so is late
    focused.poll()
    assert focused.hands == (Hand(), Hand())
    xr.enter("VISIBLE")
    focused.poll()
    syncs = xr.count("sync_actions")
    focused.poll()
    assert xr.count("sync_actions") == syncs


def test_a_pulse_reaches_its_hand(xr, focused):
    focused.pulse(1, 0.5, 0.02)
    focused.pulse(0, 7.0, 0.0)
    focused.pulse(0, 0.0, 1.0)
    assert xr.pulses == [(RIGHT, 0.5, 20_000_000), (LEFT, 1.0, 1)]
    xr.enter("VISIBLE")
    focused.poll()
    focused.pulse(0, 1.0, 1.0)
    assert len(xr.pulses) == 2
    xr.enter("FOCUSED")
    focused.poll()
    xr.faults["apply_haptic_feedback"] = "SessionNotFocused"
    focused.pulse(0, 1.0, 1.0)


# --- the report ---


def test_the_report_names_runtime_and_headset(xr):
    assert describe_headset() == HeadsetReport("Fake runtime 2.5.1", "Fake headset", "")
    assert not xr.alive
    assert xr.count("create_session") == 0


@pytest.mark.parametrize(
    ("call", "error", "runtime"),
    [
        ("enumerate_instance_extension_properties", "RuntimeUnavailableError", ""),
        ("create_instance", "RuntimeFailureError", ""),
        ("get_system", "FormFactorUnavailableError", "Fake runtime 2.5.1"),
        (None, None, "Fake runtime 2.5.1"),  # only OpenGL is missing
    ],
)
def test_the_report_says_what_is_missing(xr, call, error, runtime):
    if call is None:
        xr.extensions = []
    xr.faults[call] = error
    report = describe_headset()
    assert report[:2] == (runtime, "" if call else "Fake headset")
    assert report.missing and ("OpenGL" in report.missing) == (call is None)
    assert not xr.alive


def doctor_lines(monkeypatch, capsys, tmp_path, script):
    """Lines of the doctor with a fake `xr`, which runs `script` first."""
    root = Path(__file__).parents[3]
    (tmp_path / "xr.py").write_text(
        f"import sys; sys.path.insert(0, {str(root)!r})\n"
        "from tests.stage.headset.fake_xr import FakeXr\n"
        f"fake = sys.modules['xr'] = FakeXr()\n{script}\n"
    )
    for check in ("_python", "_packages", "_cache", "_fishes", "_display", "_headless"):
        monkeypatch.setattr(doctor_command, check, list)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{root}")
    assert main(["doctor"]) == 0
    printed = capsys.readouterr()
    assert not printed.err
    return printed.out.splitlines()


@pytest.mark.parametrize(
    ("script", "lines"),
    [
        ("print('noise')",
         ["ok  OpenXR runtime           Fake runtime 2.5.1", "ok  headset                  Fake"]),
        ("fake.faults['get_system'] = 'FormFactorUnavailableError'",
         ["ok  OpenXR runtime           Fake runtime 2.5.1", "--  headset                  no he"]),
        ("fake.faults['create_instance'] = 'RuntimeUnavailableError'",
         ["--  OpenXR runtime           no OpenXR runtime: install"]),
        ("import os; os.abort()", ["--  OpenXR runtime           it crashes"]),
    ],
)  # fmt: skip
def test_the_doctor_has_lines_for_the_headset(monkeypatch, capsys, tmp_path, script, lines):
    printed = doctor_lines(monkeypatch, capsys, tmp_path, script)
    found = [line for line in printed if "OpenXR" in line or line[4:].startswith("headset")]
    assert [line[: len(start)] for line, start in zip(found, lines, strict=True)] == lines
    assert "headset    works" in printed


def test_the_doctor_does_not_wait_for_a_slow_runtime(monkeypatch):
    def slow(*_, **settings):
        raise subprocess.TimeoutExpired("python", settings["timeout"])

    monkeypatch.setattr(doctor_command, "missing_packages", lambda extra: [])
    monkeypatch.setattr(doctor_command.subprocess, "run", slow)
    [finding] = doctor_command._headset()
    assert "no answer" in finding.text
    assert not finding.needed_by


def test_the_doctor_names_the_missing_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "xr", None)
    assert doctor_command._headset() == []
