"""Names of inputs, their meaning, and bindings from a settings file."""

from collections import Counter

import glfw
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.dive import settings as bindings
from subsea.dive.settings import (
    ACTIONS,
    COMMANDS,
    CONTROLS,
    KEYS,
    USUAL,
    bindings_of,
    input_name,
    key_name,
)

CTRL, SHIFT, ALT = glfw.MOD_CONTROL, glfw.MOD_SHIFT, glfw.MOD_ALT


def test_controls_are_complete_and_no_input_has_two():
    assert tuple(CONTROLS) == (*ACTIONS, *COMMANDS)
    uses = Counter(name for control in CONTROLS.values() for name in control.inputs)
    assert [name for name, number in uses.items() if number > 1] == ["Esc"]  # menu and alight
    for control in CONTROLS.values():
        assert [input_name(name) for name in control.inputs] == list(control.inputs)


def test_keys_buttons_and_axes_have_the_numbers_of_the_window_library():
    numbers = {
        value
        for name, value in vars(glfw).items()
        if name.startswith("KEY_") and name not in ("KEY_UNKNOWN", "KEY_LAST")
    }
    assert set(KEYS) | {glfw.KEY_WORLD_1, glfw.KEY_WORLD_2} == numbers
    for name, key in (
        ("PageUp", glfw.KEY_PAGE_UP), ("Esc", glfw.KEY_ESCAPE), ("F12", glfw.KEY_F12),
        ("Num7", glfw.KEY_KP_7), ("`", glfw.KEY_GRAVE_ACCENT), ("W", glfw.KEY_W),
    ):  # fmt: skip
        assert KEYS[key] == name
    assert bindings.BUTTONS[glfw.MOUSE_BUTTON_MIDDLE] == "middle"
    assert len(bindings.PAD_BUTTONS) == glfw.GAMEPAD_BUTTON_LAST + 1
    assert bindings.PAD_BUTTONS[glfw.GAMEPAD_BUTTON_DPAD_UP] == "up"
    assert bindings.PAD_BUTTONS[glfw.GAMEPAD_BUTTON_RIGHT_BUMPER] == "right bumper"
    assert len(bindings.PAD_AXES) == glfw.GAMEPAD_AXIS_LAST + 1
    assert bindings.PAD_AXES[glfw.GAMEPAD_AXIS_RIGHT_TRIGGER][0] == "right trigger"


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("w", "W"), ("page up", "PageUp"), ("PAGE_UP", "PageUp"), ("escape", "Esc"), ("-", "-"),
        ("shift+ctrl+q", "Ctrl+Shift+Q"), ("Ctrl + =", "Ctrl+="), ("num+", "Num+"), (" ,", ","),
        ("Mouse-Left", "mouse left"), ("pad left-stick up", "pad left stick up"),
        ("pad a", "pad A"), ("left ctrl", "LeftCtrl"),
    ],
)  # fmt: skip
def test_input_names_ignore_case_and_separators(text, name):
    assert input_name(text) == name


@pytest.mark.parametrize(
    ("controls", "fault"),
    [
        ({"ahed": ["W"]}, "unknown control 'ahed'; did you mean 'ahead'?"),
        ({"ahead": ["pad left trigge"]}, "'ahead': unknown input 'pad left trigge'; did you mean "
         "'pad left trigger'?"),
        ({"ahead": ["§§"]}, "'ahead': unknown input '§§', expected one such as 'W'"),
        ({"ahead": ["Ctrl+"]}, "unknown input 'Ctrl+'"),
        ({"ahead": [""]}, "unknown input ''"),
        ({"ahead": ["Ctrl+mouse left"]}, "only keys go with Ctrl"),
        ({"ahead": ["W"], "rise": ["w"]}, "'W' cannot be both 'ahead' and 'rise'"),
    ],
)  # fmt: skip
def test_invalid_bindings_are_reported(controls, fault):
    with pytest.raises(UserError) as told:
        bindings_of(controls)
    assert fault in str(told.value)


@given(st.text(max_size=20))
def test_any_text_is_a_name_or_a_fault(text):
    try:
        name = input_name(text)
    except UserError:
        return
    assert input_name(name) == name


def test_a_binding_in_the_file_replaces_a_default_one():
    found = bindings_of({"rise": ["W"], "help": []})
    assert found.control("W") == "rise"
    assert found.inputs("ahead") == ("mouse left", "pad left stick up")
    assert found.control("E") is None
    assert found.inputs("help") == ()
    assert found.inputs("dive") == USUAL.inputs("dive")


def test_escape_alights_from_a_fish_and_opens_the_menu_elsewhere():
    assert USUAL.key(glfw.KEY_ESCAPE, 0) == "menu"
    assert USUAL.key(glfw.KEY_ESCAPE, 0, riding=True) == "alight"
    assert USUAL.control("pad B") is None
    found = bindings_of({"alight": ["Space"], "full stop": ["Space"]})
    assert found.control("Space", riding=True) == "alight"
    assert found.control("Space") == "full stop"


def test_a_key_counts_with_others_held_unless_these_mean_something_together():
    found = bindings_of({"leave": ["Ctrl+Shift+Q"], "film": ["Alt+F10"]})
    q = glfw.KEY_Q
    assert found.key(q, CTRL | SHIFT) == "leave"
    assert [found.key(q, held) for held in (0, SHIFT, CTRL)] == ["dive"] * 3
    assert found.key(q, ALT) is None  # reserved for the desktop
    assert found.key(glfw.KEY_F10, ALT) == "film"
    assert found.key(-1, 0) is None
    assert key_name(q, CTRL | SHIFT) == "Ctrl+Shift+Q"
