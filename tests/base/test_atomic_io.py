"""A result is written whole, or nothing is left of it."""

import errno
import os
import time

import pytest

from subsea.base.errors import TransientError, UserError
from subsea.base.files import (
    check_file,
    check_folder,
    partial_folder,
    remove_abandoned,
    replacing,
)


def test_checks_leave_no_files(tmp_path):
    check_file(tmp_path / "new" / "folder" / "a.json")
    check_folder(tmp_path / "frames")
    assert not list(tmp_path.iterdir())


def test_impossible_folders_are_refused(tmp_path):
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "new", "/proc", "/proc/new"):
        with pytest.raises(UserError, match=str(folder)):
            check_file(tmp_path / folder / "a.png")


def test_a_file_appears_at_the_end_in_one_step(tmp_path):
    path = tmp_path / "new" / "a.txt"
    with replacing(path) as temporary:
        temporary.write_text("whole")
        assert not path.exists()
        assert temporary.parent == path.parent
    assert [file.name for file in path.parent.iterdir()] == ["a.txt"]
    assert path.read_text() == "whole"


def test_links_are_preserved(tmp_path):
    file, link = tmp_path / "kept" / "a.txt", tmp_path / "link.txt"
    link.symlink_to(file)
    for text in ("made", "replaced"):
        with replacing(link) as temporary:
            temporary.write_text(text)
        assert link.is_symlink()
        assert file.read_text() == text
    assert [one.name for one in file.parent.iterdir()] == ["a.txt"]


@pytest.mark.parametrize("fault", [RuntimeError, KeyboardInterrupt, OSError])
def test_a_fault_leaves_the_old_file_and_no_new_folder(tmp_path, fault):
    former, new = tmp_path / "a.txt", tmp_path / "new" / "folder" / "a.txt"
    former.write_text("former")
    for path in (former, new):
        expected = UserError if fault is OSError else fault
        with pytest.raises(expected), replacing(path) as temporary:
            temporary.write_text("half")
            raise fault
    assert [file.name for file in tmp_path.iterdir()] == ["a.txt"]
    assert former.read_text() == "former"


def test_stale_partial_files_are_removed(tmp_path):
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


@pytest.mark.parametrize("name", ["a" * 251 + ".txt", "é" * 125 + ".txt"])
def test_the_longest_name_has_a_partial_file_too(tmp_path, name):
    check_file(tmp_path / name)
    # Libraries and films add up to seven letters to the temporary name.
    with replacing(tmp_path / name) as temporary:
        temporary.with_name(f"{temporary.name}.tagged").write_text("")
        temporary.write_text("whole")
    assert (tmp_path / name).read_text() == "whole"
    first, second = tmp_path / ("a" * 250 + "1"), tmp_path / ("a" * 250 + "2")
    with replacing(first) as one, replacing(second) as two:
        assert one != two
        one.write_text("")
        two.write_text("")


def test_links_that_loop_are_refused_before_the_work(tmp_path):
    loop, other = tmp_path / "loop", tmp_path / "other"
    loop.symlink_to(other)
    other.symlink_to(loop)
    with pytest.raises(UserError, match="loop: Too many levels of symbolic links"):
        check_file(loop)
    with pytest.raises(UserError, match="Too many levels"), replacing(loop) as temporary:
        temporary.write_text("")
    for path in (loop / "a.txt", loop / "new" / "a.txt"):
        with pytest.raises(UserError, match="loop"):
            check_file(path)
    assert loop.is_symlink()


def test_a_link_to_a_missing_folder_is_followed(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "kept" / "here")
    check_file(tmp_path / "link" / "a.txt")
    with replacing(tmp_path / "link" / "a.txt") as temporary:
        temporary.write_text("whole")
    assert (tmp_path / "kept" / "here" / "a.txt").read_text() == "whole"


def test_pipes_and_devices_are_not_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "null").symlink_to("/dev/null")
    for name in ("pipe", "null"):
        with pytest.raises(UserError, match=f"{name}: not a regular file"):
            check_file(tmp_path / name)
        with pytest.raises(UserError, match="not a reg"), replacing(tmp_path / name) as temporary:
            temporary.write_text("")


def test_partial_files_are_never_written_through_a_link(tmp_path):
    other = tmp_path / "precious"
    other.write_text("mine")
    parts = [tmp_path / f".{name}.{os.getpid()}.part" for name in ("a.txt", "folder")]
    for part in parts:
        part.symlink_to(other)
    with replacing(tmp_path / "a.txt") as temporary:
        assert temporary == parts[0]
        temporary.write_text("whole")
    parts[1].unlink()
    parts[1].mkdir()
    (parts[1] / "leftover").symlink_to(other)
    with partial_folder(tmp_path / "folder") as folder:
        assert folder == parts[1] and not list(folder.iterdir())
    assert other.read_text() == "mine"
    assert {path.name for path in tmp_path.iterdir()} == {"a.txt", "precious"}


def test_secrets_are_never_readable_by_others(tmp_path):
    before = os.umask(0)
    try:
        with replacing(tmp_path / "secret", 0o600) as temporary:
            assert temporary.stat().st_mode & 0o777 == 0o600
            temporary.write_text("word")
    finally:
        os.umask(before)
    assert (tmp_path / "secret").stat().st_mode & 0o777 == 0o600


def test_a_full_disk_is_an_error_that_may_pass(tmp_path):
    with pytest.raises(TransientError, match="cannot write"), replacing(tmp_path / "a.txt"):
        raise OSError(errno.ENOSPC, "no room")


def test_leftovers_of_ended_processes_are_removed(tmp_path):
    mine, gone = os.getpid(), 7777777
    for name in (f".a.txt.{mine}.part", f".a.txt.{gone}.part", f".b.txt.{gone}.part"):
        (tmp_path / name).touch()
    for number in (mine, gone):
        (tmp_path / f".records.{number}.part" / "tmp").mkdir(parents=True)
    remove_abandoned(tmp_path, "a.txt")
    assert not (tmp_path / f".a.txt.{gone}.part").exists() and len(list(tmp_path.iterdir())) == 4
    remove_abandoned(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {
        f".a.txt.{mine}.part", f".records.{mine}.part"
    }  # fmt: skip
