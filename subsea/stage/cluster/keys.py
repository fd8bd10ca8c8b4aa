"""Key pairs that authenticate master and nodes (ZeroMQ CURVE).

A folder holds the public NAME.key and NAME.key_secret, which only the computer NAME may have. The
files are ZeroMQ certificates.
"""

import os
import re
import struct
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

import zmq
import zmq.auth
from zmq.utils import z85

from subsea.base.errors import UserError, unreadable
from subsea.base.files import OWN_MODE, check_folder, check_input, refuse_shared
from subsea.stage.theatre.theatre_file import NAME

PUBLIC, SECRET = ".key", ".key_secret"
EXISTS = "exists; remove it on every computer before making another"
HEADER = "# subsea: {what} of {name}\nmetadata\ncurve\n"


class Keys(NamedTuple):
    """The keys of one computer."""

    public: bytes  # Z85, 40 bytes, as all of them
    secret: bytes
    others: dict[str, bytes]  # public keys of the others, by name


def write_keys(folder: Path, names: Sequence[str]) -> list[Path]:
    """Write a new key pair for each computer; return the files, public and secret in turn.

    Only the owner can read secret files. If a name is invalid, or has keys already, nothing is
    written: UserError.
    """
    for name in names:
        if not re.search(NAME, name):
            raise UserError(f"{name!r}: expected a name of letters, digits, - and _, 64 at most")
        for path in (folder / f"{name}{suffix}" for suffix in (PUBLIC, SECRET)):
            if path.exists():
                raise UserError(EXISTS, file=path)
    for name in names:
        if names.count(name) > 1:
            raise UserError(f"{name!r} was given twice")
    check_folder(folder)
    folder.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    with ExitStack() as undo:  # another command may write into the folder at the same time
        for name in names:
            public, secret = (key.decode() for key in zmq.curve_keypair())
            for suffix, what, mode in (
                (PUBLIC, "public key", 0o644),
                (SECRET, "SECRET key, for nobody but that computer,", OWN_MODE),
            ):
                text = HEADER.format(what=what, name=name) + f'    public-key = "{public}"\n'
                if suffix == SECRET:
                    text += f'    secret-key = "{secret}"\n'
                path = folder / f"{name}{suffix}"
                _create(path, text, mode, undo)
                written.append(path)
        undo.pop_all()
    return written


def _create(path: Path, text: str, mode: int, undo: ExitStack) -> None:
    """Write a file that nobody else has made; `undo` removes it."""
    try:
        # With its mode, so that others never can read it.
        number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
        undo.callback(path.unlink, missing_ok=True)
        with os.fdopen(number, "w", encoding="ascii") as file:
            file.write(text)
    except FileExistsError as fault:
        raise UserError(EXISTS, file=path) from fault
    except OSError as fault:
        raise UserError(f"cannot write ({fault.strerror})", file=path) from fault


def read_keys(folder: Path, name: str, others: Sequence[str]) -> Keys:
    """Read the pair of `name` and the public keys of `others`; UserError if one is missing."""
    path = folder / f"{name}{SECRET}"
    public, secret = _read(path)
    if secret is None:
        raise UserError("holds no secret key", file=path)
    refuse_shared(path)
    return Keys(public, secret, {other: _read(folder / f"{other}{PUBLIC}")[0] for other in others})


def _read(path: Path) -> tuple[bytes, bytes | None]:
    try:
        check_input(path)
        public, secret = zmq.auth.load_certificate(path)
    except UserError as fault:
        if not isinstance(fault.__cause__, FileNotFoundError):
            raise
        hint = f"no such file; `subsea keys {path.parent} NAME...` makes keys"
        raise UserError(hint, file=path) from fault
    except OSError as fault:
        raise unreadable(path, fault) from fault
    except (ValueError, IndexError) as fault:  # a missing or empty line
        raise UserError("holds no key", file=path) from fault
    try:
        sizes = {len(z85.decode(key)) for key in (public, secret) if key is not None}
    except (ValueError, KeyError, struct.error):  # not all texts of 40 letters are numbers in Z85
        sizes = set()
    if sizes != {32}:
        raise UserError("holds no key of 40 letters, as Z85 has them", file=path)
    return public, secret
