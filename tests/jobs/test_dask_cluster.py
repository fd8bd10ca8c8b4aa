"""A client of Dask trusts no unknown scheduler, and may ask for TLS."""

import asyncio
import pickle
import socket
import struct
import threading
from contextlib import closing

import msgspec
import pytest
from distributed import Scheduler, Security

from subsea.base.errors import UserError
from subsea.jobs import dask_cluster


class Trap:
    """An object that writes a file where it is unpickled."""

    def __init__(self, path):
        self._path = path

    def __reduce__(self):
        return open, (str(self._path), "w")


def frames(*parts):
    prelude = struct.pack(f"<{1 + len(parts)}Q", len(parts), *map(len, parts))
    return struct.pack("<Q", len(prelude) + sum(map(len, parts))) + prelude + b"".join(parts)


def test_no_object_of_an_unknown_scheduler_is_unpickled(tmp_path, monkeypatch):
    monkeypatch.setattr(dask_cluster, "CONNECT_S", 1.0)
    trap = {"pickled-obj": pickle.dumps(Trap(tmp_path / "sprung")), "num-sub-frames": 0}
    encode = msgspec.msgpack.encode
    greeting = frames(encode({"x": {"__Pickled__": 1}}), encode(trap))

    def answer(listener):
        peer, _ = listener.accept()
        with peer:
            peer.sendall(greeting * 2)
            while peer.recv(4096):
                pass

    with closing(socket.create_server(("127.0.0.1", 0))) as listener:
        thread = threading.Thread(target=answer, args=(listener,), daemon=True)
        thread.start()
        address = f"tcp://127.0.0.1:{listener.getsockname()[1]}"
        with pytest.raises(UserError, match="no Dask scheduler answers there"):
            dask_cluster._connect(address)
        thread.join(10.0)
    assert not (tmp_path / "sprung").exists()


@pytest.mark.parametrize("scheme", ["tcp", "tls"])
def test_a_scheduler_is_known_by_its_answer(certificate, scheme):
    cert, key = map(str, certificate)
    ours = (certificate[0], *certificate) if scheme == "tls" else None
    files = {"tls_ca_file": cert, "tls_scheduler_cert": cert, "tls_scheduler_key": key}
    theirs = Security(require_encryption=True, **files) if scheme == "tls" else Security()

    async def asked():
        options = {"protocol": scheme, "host": "127.0.0.1", "port": 0, "security": theirs}
        async with Scheduler(dashboard_address="127.0.0.1:0", **options) as scheduler:
            security = dask_cluster._security(scheduler.address, ours)
            await asyncio.wait_for(dask_cluster._identify(scheduler.address, security), 10.0)

    asyncio.run(asked())


def test_files_of_tls_are_checked_before_the_address(certificate, tmp_path):
    cert, key = certificate
    for address, tls, words in (
        ("tcp://127.0.0.1:9", (cert, cert, key), "expected tls://HOST:PORT with --cluster-tls"),
        ("tls://127.0.0.1:9", (cert, cert, tmp_path / "key"), "key: no such file"),
        ("tls://127.0.0.1:9", (cert, key, key), "expected authority, certificate and key in PEM"),
    ):
        with pytest.raises(UserError, match=words):
            dask_cluster._connect(address, tls)
