"""Settings that a visitor changes act at once and are kept, without a window."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.base.language import language, set_language
from subsea.dive.settings import (
    COMFORTS,
    CONTROLS,
    DEFAULTS,
    KEYS,
    MODIFIER_KEYS,
    default_text,
    is_key,
    read_settings,
)
from subsea.ui.preferences import Preferences


@pytest.fixture(autouse=True)
def english():
    yield
    set_language("en")


def kept(tmp_path, text, change):
    """The settings file after a change in a dive that began with it."""
    file = tmp_path / "folder/settings.toml"
    if text is not None:
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)
    followed = []
    preferences = Preferences(read_settings(file) if text else DEFAULTS, file, followed.append)
    change(preferences)
    assert followed[-1] is preferences.settings
    preferences.save()
    assert read_settings(file) == preferences.settings
    return file.read_text()


@pytest.mark.parametrize("text", [None, "", default_text(), "[mouse]\nsensitivity = 2 # fast\n"])
def test_changes_are_kept_and_the_rest_of_the_file_stays(tmp_path, text):
    def change(preferences):
        preferences.set_language("ja")
        preferences.set_comfort(COMFORTS["calm"])
        preferences.keep_sound(volume=0.4, mute=False)
        preferences.bind("lights", "Z")

    after = kept(tmp_path, text, change)
    assert 'language = "ja"' in after and 'lights = ["Z", "pad up", "pad left bumper"]' in after
    assert language() == "ja"
    for line in (text or "").splitlines():
        assert line in after


def test_nothing_is_written_without_a_change_or_a_file(tmp_path):
    file = tmp_path / "settings.toml"
    Preferences(DEFAULTS, file, lambda settings: None).save()
    assert not file.exists()
    nowhere = Preferences(DEFAULTS, None, lambda settings: None)
    nowhere.set_language("de")
    nowhere.save()
    assert nowhere.settings.display.language == "de"


def test_a_key_has_one_control():
    preferences = Preferences(DEFAULTS, None, lambda settings: None)
    preferences.bind("ahead", "H")
    bindings = preferences.settings.bindings
    assert bindings.inputs("ahead") == ("H", "mouse left", "pad left stick up")
    assert bindings.inputs("help") == ("F1", "pad back") and bindings.control("W") is None
    preferences.bind("help", "H")
    assert "H" not in preferences.settings.bindings.inputs("ahead")
    preferences.usual_keys()
    assert preferences.settings.bindings == DEFAULTS.bindings


@given(
    st.lists(
        st.tuples(
            st.sampled_from(list(CONTROLS)),
            st.sampled_from([key for key in KEYS.values() if key not in MODIFIER_KEYS]),
        ),
        max_size=12,
    )
)
def test_any_keys_can_be_bound_in_any_order(steps):
    preferences = Preferences(DEFAULTS, None, lambda settings: None)
    for control, key in steps:
        preferences.bind(control, key)
        bindings = preferences.settings.bindings
        assert [name for name in bindings.inputs(control) if is_key(name)] == [key]
        assert {one for one in bindings.controls[key] if one != "alight"} <= {control}


def test_the_next_visitor_of_a_kiosk_finds_what_the_operator_set():
    followed = []
    start = DEFAULTS
    preferences = Preferences(start, None, followed.append)
    preferences.restore()
    assert not followed
    preferences.set_language("fr")
    preferences.set_comfort(COMFORTS["free"])
    preferences.save()
    preferences.restore()
    assert followed[-1] is start and language() == "en"
    assert preferences.settings is start


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    file = tmp_path / "file/settings.toml"
    preferences = Preferences(DEFAULTS, file, lambda settings: None)
    preferences.set_language("es")
    with pytest.raises(UserError, match=r"settings\.toml: the settings were not kept"):
        preferences.save()
    torn = tmp_path / "torn.toml"
    torn.write_text("[display")
    preferences = Preferences(DEFAULTS, torn, lambda settings: None)
    preferences.set_language("es")
    with pytest.raises(UserError, match=r"torn\.toml: the settings were not kept"):
        preferences.save()
    assert torn.read_text() == "[display"
