"""The front door: `python run_submarine.py …` is `subsea dive …`."""

import sys

from subsea.cli.main import main

if __name__ == "__main__":
    sys.exit(main(["dive", *sys.argv[1:]]))
