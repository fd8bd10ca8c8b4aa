"""List the kernels of a dive in `assets/kernels.json`, for `core/kernels/warm_up.py`.

.venv/bin/python tools/list_kernels.py

Makes two pictures of each scenario that is shipped, with nothing compiled yet, and notes what is
compiled for them: for which types, and which kernel calls which. Takes a minute or two. Run it
after kernels were added, removed, or given other types.
"""

import argparse
import json
import os
import sys
import tempfile
from typing import Any

from numba import config, types
from numba.core import dispatcher, event


class Noted(event.Listener):  # type: ignore[misc]
    """What was compiled, each kernel after those that it calls."""

    def __init__(self) -> None:
        self.types: dict[Any, int] = {}
        self.spelled: list[Any] = []
        self.kernels: dict[tuple[str, tuple[int, ...], bool], list[int]] = {}
        self.calls: list[set[int]] = []  # of each kernel that is being compiled

    def on_start(self, event: event.Event) -> None:
        """A kernel is being compiled."""
        self.calls.append(set())

    def on_end(self, event: event.Event) -> None:
        """It is; those that it calls were noted before."""
        calls = self.calls.pop()
        kernel = event.data["dispatcher"]
        if _is_found(kernel):
            key = self._key(kernel, event.data["args"], bool(self.calls))
            self.kernels[key] = sorted(calls)

    def called(self, kernel: Any, signature: Any) -> None:
        """The one that is being compiled calls another, which was compiled by now."""
        if self.calls and _is_found(kernel):
            name, given, _ = key = self._key(kernel, signature, True)
            if key not in self.kernels:  # Python called it before; another process compiles both
                self.kernels[key] = self.kernels[name, given, False]
            self.calls[-1].add([*self.kernels].index(key))

    def _key(self, kernel: Any, signature: Any, inner: bool) -> tuple[str, tuple[int, ...], bool]:
        return _name(kernel.py_func), tuple(self._number(kind) for kind in signature), inner

    def _number(self, kind: Any) -> int:
        """The number of a type in the list, where it is put if it is not there yet."""
        if kind not in self.types:
            spelled = self._spell(kind)
            self.types[kind] = len(self.spelled)
            self.spelled.append(spelled)
        return self.types[kind]

    def _spell(self, kind: Any) -> Any:
        match kind:
            case types.Array():
                assert kind.aligned, kind
                return ["array", self._number(kind.dtype), kind.ndim, kind.layout, kind.mutable]
            case types.IntegerLiteral():
                return ["literal", kind.literal_value]
            case types.StructRef():
                fields = [[field, self._number(item)] for field, item in kind._fields]
                return [_name(type(kind)), *fields]
            case types.BaseNamedTuple():
                return [_name(kind.instance_class), *map(self._number, kind.types)]
            case types.BaseTuple():
                return ["tuple", *map(self._number, kind.types)]
        return str(kind)


def _name(thing: Any) -> str:
    return f"{thing.__module__}.{thing.__qualname__}"


def _is_found(kernel: Any) -> bool:
    """Whether another process finds it by its name: not what is made while the program runs."""
    function = kernel.py_func
    return getattr(sys.modules.get(function.__module__), function.__qualname__, None) is kernel


def write() -> None:
    """Write the list."""
    noted = Noted()
    template = dispatcher.Dispatcher.get_call_template

    def get_call_template(self: Any, args: Any, kws: Any) -> Any:
        found = template(self, args, kws)
        noted.called(self, found[2])
        return found

    dispatcher._DispatcherBase.get_call_template = get_call_template
    from subsea.cli.main import main
    from subsea.core.atomic_io import replacing
    from subsea.core.kernels.warm_up import LIST
    from subsea.core.resources import resource_names
    from subsea.dive import start
    from subsea.scenario.load import SHIPPED

    start.precompile = lambda tell: None
    with event.install_listener("numba:compile", noted):
        for scenario in resource_names(SHIPPED, ".toml"):
            if main(["benchmark", "--scenario", scenario, "--frames", "2", "--size", "64x64"]):
                sys.exit(f"list_kernels: no picture of {scenario}")
            print(f"{scenario}: {len(noted.kernels)} kernels by now")
    kernels = [[*key, calls] for key, calls in noted.kernels.items()]
    with replacing(LIST) as part:
        part.write_text(
            f'{{\n"types": [\n{_rows(noted.spelled)}\n],\n"kernels": [\n{_rows(kernels)}\n]\n}}\n',
            encoding="utf-8",
        )


def _rows(values: list[Any]) -> str:
    return ",\n".join(json.dumps(value, separators=(",", ":")) for value in values)


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    with tempfile.TemporaryDirectory() as folder:
        os.environ["NUMBA_CACHE_DIR"] = os.environ["XDG_CACHE_HOME"] = folder
        config.reload_config()
        write()
