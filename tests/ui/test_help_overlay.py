"""The help has room for the words and keys of every language."""

import pytest
from imgui_bundle import imgui

from subsea.base.language import LANGUAGES, japanese_font, latin_font, set_language
from subsea.dive.settings import CONTROLS, USUAL, Settings, is_key, key_words
from subsea.ui import help_overlay
from subsea.ui.help_overlay import (
    COLUMNS,
    GROUPS,
    MARGIN,
    MOUSE_WIDE,
    Row,
    column_width,
    columns_of,
    draw_help,
    help_content,
)

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


def test_every_line_is_in_its_column(letters):
    for code in LANGUAGES:
        set_language(code)
        columns = columns_of(help_content(Settings().bindings).groups, 2)
        assert len(columns) == 2
        wide = MOUSE_WIDE + MARGIN
        for column in columns:
            words_x, column_wide = column_width(column, LINE)
            for _, rows in column:
                for row in rows:
                    texts = imgui.calc_text_size(row.what).x / LINE
                    assert words_x + texts <= column_wide - MARGIN + 1e-6
            wide += column_wide
        assert wide < 1280 / LINE - 1.0  # letters keep their size
    usual = column_width(columns[0], LINE)[0]
    long = [("Keys", (Row(("Ctrl+PageUp", "Ctrl+PageDown"), "words"),))]
    assert column_width(long, LINE)[0] > usual + 3.0


def test_it_has_every_control_that_has_a_key():
    shown = [control for _, pairs in GROUPS for controls, _ in pairs for control in controls]
    assert sorted(shown) == sorted(CONTROLS)  # each once
    content = help_content(Settings().bindings)
    keys = sum(len(row.keys) for _, rows in content.groups for row in rows)
    with_keys = [name for name in CONTROLS if any(map(is_key, USUAL.inputs(name)))]
    assert keys == len(with_keys)


def test_columns_keep_the_order_of_groups():
    groups = [(str(k), (Row((), "words"),) * rows) for k, rows in enumerate((7, 7, 4, 6, 2, 4))]
    highest = []
    for number in range(2, COLUMNS + 1):
        columns = columns_of(groups, number)
        assert [group for column in columns for group in column] == groups
        highest.append(max(sum(1 + len(rows) for _, rows in column) for column in columns))
    assert highest[0] < 0.7 * sum(1 + len(rows) for _, rows in groups)
    assert highest[1] < 0.8 * highest[0]


def test_larger_letters_stay_larger_in_a_small_window(letters, monkeypatch):
    imgui.get_io().display_size = imgui.ImVec2(1280, 720)
    drawn = []
    monkeypatch.setattr(help_overlay, "_mouse", lambda *place: drawn.append(place[4]))
    for size in (LINE, 1.7 * LINE):
        imgui.push_font(None, size)
        draw_help(help_content(Settings().bindings), 1.0, 560.0)
        imgui.pop_font()
    usual, large = drawn
    assert usual == LINE and large > 1.2 * LINE


def test_keys_have_the_names_of_a_visitors_keyboard():
    set_language("de")
    try:
        assert (
            key_words("Space") == "Leertaste" and key_words("Ctrl+Shift+F1") == "Strg+Umschalt+F1"
        )
        assert key_words("Num+") == "Num+" and key_words("W") == "W"
    finally:
        set_language("en")
