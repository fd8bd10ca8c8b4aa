"""Key files: owners, permissions, and invalid keys."""

import stat

import pytest
import zmq

from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.stage.cluster.keys import read_keys, write_keys

NAMES = ["master", "left", "right"]


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "keys"


def test_each_name_gets_its_own_pair(folder):
    files = write_keys(folder, NAMES)
    assert sorted(files) == sorted(folder.iterdir())
    keys = {name: read_keys(folder, name, NAMES) for name in NAMES}
    assert len({key.secret for key in keys.values()} | {k.public for k in keys.values()}) == 6
    for one in keys.values():
        assert one.others == {name: keys[name].public for name in NAMES}


def test_only_the_owner_can_read_a_secret(folder):
    for file in write_keys(folder, NAMES):
        secret = file.suffix == ".key_secret"
        assert stat.S_IMODE(file.stat().st_mode) & 0o077 == 0 or not secret
        assert ("secret-key" in file.read_text()) == secret
    path = folder / "left.key_secret"
    path.chmod(0o640)
    with pytest.raises(UserError, match=r"others may read it \(mode 640\)"):
        read_keys(folder, "left", [])


def test_keys_are_not_overwritten(folder):
    write_keys(folder, ["left"])
    before = (folder / "left.key").read_bytes()
    with pytest.raises(UserError, match=r"left\.key: exists;"):
        write_keys(folder, ["right", "left"])
    assert (folder / "left.key").read_bytes() == before
    assert not (folder / "right.key").exists()


def test_of_two_commands_at_once_one_refuses(folder, monkeypatch):
    """The other writes between the check and the first key."""
    pair = zmq.curve_keypair
    other = []

    def made_meanwhile():
        monkeypatch.setattr(zmq, "curve_keypair", pair)
        other.extend(write_keys(folder, ["left", "right"]))
        return pair()

    monkeypatch.setattr(zmq, "curve_keypair", made_meanwhile)
    with pytest.raises(UserError, match=r"right\.key: exists;"):
        write_keys(folder, ["middle", "right"])
    assert sorted(folder.iterdir()) == sorted(other)
    keys = read_keys(folder, "right", ["left"])
    assert keys.public == read_keys(folder, "left", ["right"]).others["right"]


@pytest.mark.parametrize(
    "name", ["", "../left", "a b", ".left", "-left", "ä", "a\n", "x" * 65, "left"]
)
def test_names_are_valid_and_unique(folder, name):
    with pytest.raises(UserError, match="twice" if name == "left" else "expected a name"):
        write_keys(folder, ["left", name])
    assert not folder.exists()


def test_invalid_keys_are_reported(folder):
    with pytest.raises(UserError, match=r"left\.key_secret: no such file; `subsea keys"):
        read_keys(folder, "left", [])
    write_keys(folder, NAMES)
    with pytest.raises(UserError, match=r"wing\.key: no such file"):
        read_keys(folder, "left", ["wing"])
    # Invalid letters, too large a number, too short, too long.
    invalid = [f"    public-key = '{key}'\n" for key in ("," * 40, "#" * 40, "short", "a" * 45)]
    for text, words in (("nothing\n", ""), ("public-key\n", ""), *((t, " of 40") for t in invalid)):
        (folder / "right.key").write_text(text)
        with pytest.raises(UserError, match=f"holds no key{words}"):
            read_keys(folder, "left", ["right"])
    secret = folder / "left.key_secret"
    secret.write_text((folder / "left.key").read_text())
    with pytest.raises(UserError, match="no secret key"):
        read_keys(folder, "left", [])


def test_the_command_makes_keys(folder, capsys):
    assert main(["keys", str(folder), "left", "right"]) == 0
    printed = capsys.readouterr().out.split()
    assert sorted(printed) == sorted(map(str, folder.iterdir()))
    read_keys(folder, "left", ["right"])
    assert main(["keys", str(folder), "left"]) == 2
    assert "exists; remove it" in capsys.readouterr().err
