"""The help has room for the words and keys of every language."""

import pytest
from imgui_bundle import imgui

from subsea.base.language import LANGUAGES, japanese_font, latin_font, set_language
from subsea.dive.settings import Settings, key_words
from subsea.ui.help_overlay import KEYS_X, MARGIN, Row, help_columns, help_content

LINE = 18.0


@pytest.fixture
def letters():
    """A gui of 640x400 without a window."""
    before, context = imgui.get_current_context(), imgui.create_context()
    imgui.set_current_context(context)
    screen = imgui.get_io()
    screen.set_ini_filename(None)
    screen.backend_flags |= imgui.BackendFlags_.renderer_has_textures
    screen.display_size = imgui.ImVec2(640, 400)
    screen.fonts.add_font_from_file_ttf(str(latin_font()), LINE)
    more = imgui.ImFontConfig()
    more.merge_mode = True
    screen.fonts.add_font_from_file_ttf(str(japanese_font()), LINE, more)
    imgui.new_frame()
    yield
    set_language("en")
    imgui.end_frame()
    imgui.destroy_context(context)
    if before is not None:
        imgui.set_current_context(before)


def test_every_line_is_in_its_box(letters):
    for code in LANGUAGES:
        set_language(code)
        content = help_content(Settings().bindings)
        words_x, wide = help_columns(content, LINE)
        for row in content.rows:
            assert words_x + imgui.calc_text_size(row.what).x / LINE <= wide - MARGIN + 1e-6
        assert wide < 640 / LINE - 2.4  # letters keep their size
    long = content._replace(rows=(Row(("Ctrl+PageUp", "Ctrl+PageDown"), "words"),))
    assert help_columns(long, LINE)[0] > KEYS_X + 10.0


def test_keys_have_the_names_of_a_visitors_keyboard():
    set_language("de")
    try:
        assert (
            key_words("Space") == "Leertaste" and key_words("Ctrl+Shift+F1") == "Strg+Umschalt+F1"
        )
        assert key_words("Num+") == "Num+" and key_words("W") == "W"
    finally:
        set_language("en")
