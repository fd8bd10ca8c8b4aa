"""The process of `subsea …`, also of `python -m subsea …`."""

import sys

from subsea.base.interrupts import run_program


def main() -> int:
    """Run `subsea` as this process and return its exit code."""
    return run_program("subsea", _command)


def _command() -> int:
    from subsea.cli.main import main  # may be interrupted, as it takes a while

    code = main()
    from subsea.base.restarts import RESTART, restart

    return restart() if code == RESTART else code


if __name__ == "__main__":
    sys.exit(main())
