"""Run a command of subsea, and fail if it compiles a kernel.

python -P count_compiled.py WORDS: prints the kernels on standard error, one a line.
"""

import sys
from typing import Any

from numba.core import event


class Compiled(event.Listener):
    """Lists functions that numba compiles."""

    def __init__(self) -> None:
        self.names: list[str] = []

    def on_start(self, event: Any) -> None:
        """Note a function."""
        function = event.data["dispatcher"].py_func
        self.names.append(f"{function.__module__}.{function.__name__}")

    def on_end(self, event: Any) -> None:
        """Do nothing."""


def main() -> int:
    """Run the command; 1 if it compiles, else its exit code."""
    from subsea.cli.main import main as subsea

    compiled = Compiled()
    with event.install_listener("numba:compile", compiled):
        code = subsea(sys.argv[1:])
    print(*compiled.names, sep="\n", file=sys.stderr, end="")
    return 1 if compiled.names else code


if __name__ == "__main__":
    sys.exit(main())
