"""Recording on a Dask cluster of real processes, one of them dying."""

import asyncio
import socket
import subprocess
import sys
import time
from contextlib import ExitStack

import distributed
import pytest

from capture.cli.main import main
from capture.recording.batch import dask_workers, record_all, record_equally
from capture.recording.record import segments_of
from subsea.base.errors import UserError
from subsea.base.system import install_command
from subsea.fish.species import load_species
from subsea.jobs import dask_cluster as module
from subsea.repertoire import write_repertoire
from tests.support.daily import only

NAMES = ["emperor_angelfish", "fusilier"]
DASK = [sys.executable, "-m", "dask"]
WORKER = ["--no-nanny", "--nthreads", "1", "--no-dashboard", "--death-timeout", "60"]


class Cluster:
    """A scheduler and a worker or more, each a process."""

    def __init__(self, folder):
        self.folder = folder
        self.processes = ExitStack()
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        port = self.address.rpartition(":")[2]
        self.scheduler = self._start(
            "scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard"
        )
        self.workers = []
        self.add_worker()

    def add_worker(self):
        self.workers.append(self._start("worker", self.address, *WORKER))

    def _start(self, *arguments):
        process = subprocess.Popen(
            [*DASK, *arguments],
            cwd=self.folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.processes.callback(process.wait)
        self.processes.callback(process.kill)
        return process

    def wait(self):
        """Until the scheduler answers."""
        port = int(self.address.rpartition(":")[2])
        for _ in range(300):
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", port)) == 0:
                    return
            time.sleep(0.1)
        pytest.fail("the scheduler does not come up")


@pytest.fixture
def dask(tmp_path_factory):
    running = Cluster(tmp_path_factory.mktemp("dask"))
    with running.processes:
        running.wait()
        yield running


@pytest.mark.nightly
def test_a_worker_that_is_killed_midway_loses_nothing(dask, repertoires, tmp_path, save_turns):
    dask.add_worker()
    saved = sum(save_turns(name, tmp_path) for name in NAMES)
    done: dict[str, int] = {}

    def tell(name, segments):
        done[name] = segments
        if sum(done.values()) == saved + 3:
            dask.workers[0].kill()

    assert (
        record_all(dict.fromkeys(NAMES, tmp_path), dask_workers(dask.address), progress=tell)
        == NAMES
    )
    assert dask.workers[0].wait() == -9
    assert dask.workers[1].poll() is None
    assert done == {name: len(segments_of(load_species(name))) for name in NAMES}
    for name in NAMES:
        write_repertoire(tmp_path / "undisturbed.h5", repertoires[name])
        expected = (tmp_path / "undisturbed.h5").read_bytes()
        assert (tmp_path / f"{name}.h5").read_bytes() == expected


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("lost", "line"),
    only(
        [("workers", "no worker for")],
        [("workers", "no worker for"), ("scheduler", "the scheduler has stopped")],
    ),
)
def test_a_lost_cluster_is_an_error_of_one_line_and_finished_segments_are_saved(
    lost, line, dask, tmp_path, monkeypatch
):
    def tell(name, segments):
        if segments == 2:
            monkeypatch.setattr(module, "NO_WORKER_S", 0.5)
            monkeypatch.setattr(module, "FETCH_S", 0.5)
            for process in dask.workers if lost == "workers" else [dask.scheduler]:
                process.kill()

    with pytest.raises(UserError, match=line) as caught:
        record_all({"fusilier": tmp_path}, dask_workers(dask.address), progress=tell)
    assert "\n" not in str(caught.value)
    assert len(list(tmp_path.glob(".fusilier.*.recording"))) >= 2


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense", "ftp://x:1", ""])
def test_an_address_without_a_scheduler_is_soon_an_error_of_one_line(
    address, tmp_path, capsys, monkeypatch
):
    assert module.CONNECT_S < 10.0  # Dask's own patience is 30 s
    monkeypatch.setattr(module, "CONNECT_S", 0.5)
    waited = []
    wait_for = asyncio.wait_for

    def waiting(what, timeout):
        waited.append(timeout)
        return wait_for(what, timeout)

    monkeypatch.setattr(asyncio, "wait_for", waiting)
    monkeypatch.setattr(distributed, "Client", pytest.fail)  # that asks once more
    code = main(["record", "fusilier", "--out", str(tmp_path), "--cluster", address])
    assert waited[0] == 0.5
    assert code == 2
    out, err = capsys.readouterr()
    assert not out
    assert err == f"subsea-capture: {address}: no Dask scheduler answers there\n"


def test_a_client_waits_as_long_as_it_should(monkeypatch):
    async def identify(address, security):
        assert address == "tcp://there"

    monkeypatch.setattr(module, "_identify", identify)
    monkeypatch.setattr(module, "CONNECT_S", 0.5)
    monkeypatch.setattr(distributed, "Client", lambda address, **given: (address, given))
    address, given = module._connect("tcp://there")
    assert address == "tcp://there"
    assert given["timeout"] == 0.5


def test_without_dask_the_error_names_the_extra(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "distributed", None)
    command = ["record", "fusilier", "--out", str(tmp_path), "--cluster", "tcp://127.0.0.1:9"]
    assert main(command) == 2
    assert f"--cluster needs Dask: run `{install_command('cluster')}`" in capsys.readouterr().err


def test_a_worker_of_another_version_refuses():
    with pytest.raises(UserError, match="another version"):
        record_equally((("fusilier", "swim_slow"), load_species("fusilier"), "of yesterday"))
