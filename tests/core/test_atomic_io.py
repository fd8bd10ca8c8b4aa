"""A result is written whole, or nothing is left of it."""

import os
import time

import pytest

from subsea.core.atomic_io import check_file, check_folder, replacing
from subsea.core.errors import UserError


def test_asking_leaves_nothing(tmp_path):
    check_file(tmp_path / "new" / "folder" / "a.json")
    check_folder(tmp_path / "frames")
    assert not list(tmp_path.iterdir())


def test_a_place_beneath_a_file_or_in_no_real_folder_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "new", "/proc", "/proc/new"):
        with pytest.raises(UserError, match=str(folder)):
            check_file(tmp_path / folder / "a.png")


def test_the_file_appears_in_the_end_and_in_one_step(tmp_path):
    path = tmp_path / "new" / "a.txt"
    with replacing(path) as temporary:
        temporary.write_text("whole")
        assert not path.exists()
        assert temporary.parent == path.parent
    assert [file.name for file in path.parent.iterdir()] == ["a.txt"]
    assert path.read_text() == "whole"


def test_a_link_stays_one(tmp_path):
    file, link = tmp_path / "kept" / "a.txt", tmp_path / "link.txt"
    link.symlink_to(file)
    for text in ("made", "replaced"):
        with replacing(link) as temporary:
            temporary.write_text(text)
        assert link.is_symlink()
        assert file.read_text() == text
    assert [one.name for one in file.parent.iterdir()] == ["a.txt"]


@pytest.mark.parametrize("fault", [RuntimeError, KeyboardInterrupt, OSError])
def test_a_fault_leaves_the_former_file_and_no_new_folder(tmp_path, fault):
    former, new = tmp_path / "a.txt", tmp_path / "new" / "folder" / "a.txt"
    former.write_text("former")
    for path in (former, new):
        expected = UserError if fault is OSError else fault
        with pytest.raises(expected), replacing(path) as temporary:
            temporary.write_text("half")
            raise fault
    assert [file.name for file in tmp_path.iterdir()] == ["a.txt"]
    assert former.read_text() == "former"


def test_parts_that_were_left_long_ago_are_removed(tmp_path):
    path, day = tmp_path / "a.txt", 86400
    for name, age in (
        (".a.txt.7.part", 2 * day),
        (".a.txt.8.part", 60),
        (".b.txt.7.part", 2 * day),
        (".b.usdc.7.part.usdc", 2 * day),
        (".my.part", 2 * day),
        (".hidden", 2 * day),
    ):
        (tmp_path / name).write_text("half")
        os.utime(tmp_path / name, (time.time() - age,) * 2)
    with replacing(path) as temporary:
        temporary.write_text("whole")
    assert {file.name for file in tmp_path.iterdir()} == {
        "a.txt", ".a.txt.8.part", ".hidden", ".my.part"
    }  # fmt: skip
