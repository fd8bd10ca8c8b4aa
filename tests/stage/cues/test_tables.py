"""Tables of cues, and texts with a command or an OSC message."""

import msgspec
import pytest

from subsea.stage.cues.tables import MidiCue, OscOut, TimecodeIn, check_message, words_of


def test_words_and_values():
    assert words_of('/eos/go 1 2.5 "a text" true') == ("/eos/go", [1, 2.5, "a text", True])
    assert words_of("next-item") == ("next-item", [])


@pytest.mark.parametrize("text", ["", "no/slash", "/a*b 1", "/open 'quote", "/grün", "/a[1]"])
def test_what_is_no_message_is_refused(text):
    with pytest.raises(ValueError, match="expected"):
        check_message(text)


@pytest.mark.parametrize(
    ("content", "kind", "message"),
    [
        ({"address": "desk:9000"}, OscOut, "an IP address and a port"),
        ({"source": "ltc", "rate": 23}, TimecodeIn, "`rate` is 23, expected 24, 25, 29.97, 30"),
        ({"source": "tape"}, TimecodeIn, "tape"),
        ({"command": "cue"}, MidiCue, "one of `note`, `control` and `program`"),
        ({"note": 1, "program": 1, "command": "cue"}, MidiCue, "one of `note`"),
        ({"note": 128, "command": "cue"}, MidiCue, "127"),
        ({"note": 1, "command": "caption 'x"}, MidiCue, "`command`"),
    ],
)
def test_odd_tables_are_refused(content, kind, message):
    with pytest.raises(msgspec.ValidationError, match=message):
        msgspec.convert(content, kind)


def test_rates_have_names():
    named = [TimecodeIn(source="midi", rate=rate).frames for rate in (24, 25.0, 29.97, 30)]
    assert named == ["24", "25", "29.97", "30"]
