"""The process of `subsea-capture …`, also of `python -m capture …`."""

import sys

from subsea.base.interrupts import run_program


def main() -> int:
    """Run `subsea-capture` as this process and return its exit code."""
    return run_program("subsea-capture", _command)


def _command() -> int:
    from capture.cli.main import main  # may be interrupted, as it takes a while

    return main()


if __name__ == "__main__":
    sys.exit(main())
