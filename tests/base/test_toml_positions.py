"""Lines of TOML files: what a reader of TOML finds is found where it stands."""

import tomllib

import pytest

from subsea.base.system import ROOT, resource_path
from subsea.base.toml_positions import key_lines, line_of, place_of

TRICKY = '''\
# a = 1

"first key" = 1  # [no.table]
water."light depth".'in cm' = 2
text = """
b = [ # no comment, and no "]" nor \\"""
c = 3"""""
other = \'\'\'
[not.a.table]\'\'\'
when = 1979-05-27 07:32:00  # a date with a blank
list = [
    1, 2,  # two entries
    "a ] # , b",
    { x = 1, y = [3, 4] },
    [[5], []],
]
inline = { a.b = 1, c = { d = "}" }, e = [] }

[ bounds ]
radius = 3
[[tour]]
name = 'a'
[[tour.waypoint]]
time = 1
[[tour.waypoint]]
time = 2
[tour.waypoint.look]
at = 1
[[tour]]
waypoint = [
    { time = 3 },
    { time = 4 }]
[water.deep."er=]"]
z = 1
'''


def places(value, above=()):
    """The places of everything in the content of a TOML file."""
    if above:
        yield above
    entries = value.items() if isinstance(value, dict) else ()
    for key, inner in enumerate(value) if isinstance(value, list) else entries:
        yield from places(inner, (*above, key))


@pytest.mark.parametrize(
    "path",
    [*sorted(resource_path("assets").rglob("*.toml")), ROOT / "pyproject.toml"],
    ids=lambda path: path.stem,
)
def test_everything_in_a_file_has_its_line(path):
    text = path.read_text()
    lines, rows = key_lines(text), text.splitlines()
    assert set(lines) == set(places(tomllib.loads(text)))
    for place, line in lines.items():
        if isinstance(place[-1], str):
            assert place[-1] in rows[line - 1], place


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_strings_comments_and_tables_of_all_kinds(ends):
    text = TRICKY.replace("\n", ends)
    lines = key_lines(text)
    assert set(lines) == set(places(tomllib.loads(text)))
    found = {
        place: line
        for place, line in lines.items()
        if place in {
            ("first key",), ("water", "light depth", "in cm"), ("text",), ("other",), ("when",),
            ("list", 1), ("list", 2), ("list", 3, "y", 1), ("list", 4, 0, 0), ("inline", "a", "b"),
            ("inline", "c", "d"), ("bounds",), ("bounds", "radius"), ("tour",),
            ("tour", 0, "waypoint", 0), ("tour", 0, "waypoint", 1, "time"),
            ("tour", 0, "waypoint", 1, "look", "at"), ("tour", 1), ("tour", 1, "waypoint", 1),
            ("water", "deep", "er=]", "z"),
        }
    }  # fmt: skip
    assert list(found.values()) == [
        3, 4, 5, 8, 10, 12, 13, 14, 15, 17, 17, 19, 20, 21, 23, 26, 28, 29, 32, 34,
    ]  # fmt: skip


def test_missing_keys_have_the_line_of_their_table():
    lines = key_lines(TRICKY)
    assert line_of(lines, place_of("tour[0].waypoint[1].follow")) == 25
    assert line_of(lines, place_of("bounds.depth_cm")) == 19
    assert line_of(lines, place_of("tour[2].name")) is None
    assert line_of(lines, place_of("fish")) is None
    assert line_of(lines, ()) is None
