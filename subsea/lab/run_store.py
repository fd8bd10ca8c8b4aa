"""The results of a sweep's runs in few files: a journal, and packed shards of a thousand runs.

A finished run is at once a line of the journal: a CRC-32 and the result as JSON. A thousand lines
become a shard, which is compressed and not changed again.
"""

import gzip
import os
import re
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import msgspec

from subsea.base.errors import TransientError, UserError, is_full_disk
from subsea.base.files import open_input, read_input, replacing
from subsea.lab.comparison import Row

SHARD_RUNS = 1000
JOURNAL = "journal.jsonl"
SHARD = re.compile(r"(\d{5,9})\.jsonl\.gz")
PIECE = 4096  # compressed bytes before a fault that may be lost with it
CHECK = 9  # characters of a CRC-32 and a blank


class RunResult(msgspec.Struct):
    """The result of a run."""

    run: str
    inputs: str  # digest of everything that the result depends on
    measures: Row


class RunFile(msgspec.Struct):
    """The result of a run in a file of its own, as earlier versions wrote it."""

    inputs: str
    measures: Row


class RunStore:
    """The results in a folder, which may be missing."""

    def __init__(self, folder: Path, tell: Callable[[str], None]) -> None:
        """`tell` gets a line for each damaged file."""
        self._folder, self._tell = folder, tell
        self._journal = folder / JOURNAL
        self._damaged: list[Path] = []
        self._file, self._lines, self._end = -1, 0, 0

    def read(self, wanted: Mapping[str, str]) -> dict[str, Row]:
        """Read the measures of runs, whose names and inputs are `wanted`.

        Files of earlier versions count, too. Runs in a damaged part of a file are missing.
        """
        rows: dict[str, Row] = {}
        try:
            files = {path.name for path in self._folder.iterdir()}
        except OSError:
            return rows
        for name, inputs in wanted.items():
            if f"{name}.json" in files:
                row = read_run_file(self._folder / f"{name}.json", inputs)
                if row is not None:
                    rows[name] = row
        self._damaged = []
        for path in self._files():
            results, whole = read_results(path)
            for one in results:
                if wanted.get(one.run) == one.inputs:
                    rows[one.run] = one.measures
            if not whole:
                self._damaged.append(path)
                self._tell(f"{path}: damaged; the runs that it has lost are made again")
        return rows

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Open the journal to add results inside; a UserError if another sweep has it open.

        Damaged files that `read` has met are written again without what they have lost.
        """
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            self._file = os.open(self._journal, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
        except OSError as fault:
            raise _unwritable(self._journal, fault) from fault
        try:
            self._lock()
            for path in self._damaged:
                if path != self._journal:
                    _write_shard(path, read_results(path)[0])
            results, whole = read_results(self._journal)
            self._lines, self._end = len(results), os.fstat(self._file).st_size
            if not whole or self._lines >= SHARD_RUNS:
                self._pack(results)
            yield
        finally:
            os.close(self._file)

    def add(self, name: str, inputs: str, row: Row) -> None:
        """Append the result of a run; on a full disk a UserError, and all others stay."""
        line = result_line(RunResult(name, inputs, row))
        left = memoryview(line)
        try:
            while left:
                left = left[os.write(self._file, left) :]
        except OSError as fault:
            os.ftruncate(self._file, self._end)
            raise _unwritable(self._journal, fault) from fault
        self._end += len(line)
        self._lines += 1
        if self._lines >= SHARD_RUNS:
            self._pack(read_results(self._journal)[0])

    def _files(self) -> list[Path]:
        """List the shards in their order, then the journal."""
        shards = [path for path in self._folder.iterdir() if SHARD.fullmatch(path.name)]
        shards.sort(key=_number_of)
        return [*shards, *([self._journal] if self._journal.is_file() else [])]

    def _lock(self) -> None:
        """Lock the journal until it is closed."""
        with suppress(ImportError):  # Windows
            from fcntl import LOCK_EX, LOCK_NB, flock

            try:
                flock(self._file, LOCK_EX | LOCK_NB)
            except BlockingIOError as fault:
                raise UserError(
                    "another sweep writes to this folder; wait for its end, or choose another",
                    file=self._folder.parent,
                ) from fault
            except OSError:  # a file system without locks
                pass

    def _pack(self, results: Sequence[RunResult]) -> None:
        """Make a shard of the results in the journal, and empty that."""
        if results:
            last = [_number_of(path) for path in self._files() if path != self._journal]
            _write_shard(self._folder / f"{max(last, default=0) + 1:05}.jsonl.gz", results)
        os.ftruncate(self._file, 0)
        self._lines = self._end = 0


def _number_of(shard: Path) -> int:
    return int(shard.name.partition(".")[0])


def result_line(result: RunResult) -> bytes:
    """Encode a result as a line of the journal."""
    text = msgspec.json.encode(result)
    return b"%08x %s\n" % (zlib.crc32(text), text)


_DECODER = msgspec.json.Decoder(RunResult)


def read_results(path: Path) -> tuple[list[RunResult], bool]:
    """Read the results in a file; False if some of it is damaged or missing."""
    content, whole = _content(path)
    results = []
    for line in content.splitlines(keepends=True):
        text = line[CHECK:-1]
        try:
            if line[-1:] != b"\n" or int(line[: CHECK - 1], 16) != zlib.crc32(text):
                raise ValueError
            results.append(_DECODER.decode(text))
        except (ValueError, msgspec.MsgspecError, RecursionError):
            whole = False
    return results, whole


def _content(path: Path) -> tuple[bytes, bool]:
    """Read a file, and unpack a shard up to its first fault; False if it has one."""
    with open_input(path) as file:
        if path.suffix != ".gz":
            return file.read(), True
        unpacker = zlib.decompressobj(wbits=31)
        parts = []
        with suppress(zlib.error):
            while piece := file.read(PIECE):
                parts.append(unpacker.decompress(piece))
        return b"".join(parts), unpacker.eof and not unpacker.unused_data


def _write_shard(path: Path, results: Sequence[RunResult]) -> None:
    content = gzip.compress(b"".join(map(result_line, results)), 6, mtime=0)
    with replacing(path) as temporary:
        temporary.write_bytes(content)


def _unwritable(path: Path, fault: OSError) -> UserError:
    kind = TransientError if is_full_disk(fault) else UserError
    return kind(f"cannot write ({os.strerror(fault.errno or 0)})", file=path)


def read_run_file(path: Path, inputs: str) -> Row | None:
    """Read the measures of a run with these inputs; None if missing, damaged or of others."""
    try:
        found = msgspec.json.decode(read_input(path), type=RunFile)
    except (UserError, msgspec.MsgspecError, ValueError, RecursionError):
        return None
    return found.measures if found.inputs == inputs else None
