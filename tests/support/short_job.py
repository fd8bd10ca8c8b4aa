"""A warm-up job that compiles nothing: it records its name, fails, or never ends."""

import os
import sys
import time
from pathlib import Path

from subsea.dive.warm_up import end_with_parent

if __name__ == "__main__":
    end_with_parent()
    if sys.argv[1] == "endless":
        time.sleep(600.0)
    if sys.argv[1] == "failing":
        sys.exit(1)
    if "SHORT_JOBS" in os.environ:
        with Path(os.environ["SHORT_JOBS"]).open("a") as file:
            file.write(f"{sys.argv[1]}\n")
