"""Warm-up jobs that compile nothing: they record their names, wait, fail, or never end."""

import os
import time
from pathlib import Path


def run(job):
    """Do a job."""
    if job.startswith("endless"):
        print(os.getpid(), flush=True)
        time.sleep(600.0)
    if job == "failing":
        raise OSError("it fails")
    while job == "waiting" and not Path(f"{os.environ['SHORT_JOBS']}-go").exists():
        time.sleep(0.05)
    with Path(os.environ["SHORT_JOBS"]).open("a") as file:
        file.write(f"{job}\n")
    return True
