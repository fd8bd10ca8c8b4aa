"""The front door: `python run_submarine.py …` is `subsea dive …`."""

import sys

from subsea.__main__ import main

if __name__ == "__main__":
    sys.argv.insert(1, "dive")
    sys.exit(main())
