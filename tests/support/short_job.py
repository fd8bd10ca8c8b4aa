"""Warm-up jobs that compile nothing: they record their names, fail, or never end."""

import os
import sys
import time
from pathlib import Path

from subsea.dive.warm_up import jobs_to_do

if __name__ == "__main__":
    for job in jobs_to_do():
        if job == "endless":
            time.sleep(600.0)
        if job == "failing":
            sys.exit(1)
        while "HELD_UNTIL" in os.environ and not Path(os.environ["HELD_UNTIL"]).exists():
            time.sleep(0.05)
        if "SHORT_JOBS" in os.environ:
            with Path(os.environ["SHORT_JOBS"]).open("a") as file:
                file.write(f"{job}\n")
