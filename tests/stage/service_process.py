"""A stand-in for the dive of a service: it reports pictures, or ends, as a file says.

    python service_process.py FILE

The file holds `run`, `hang` (it shows one picture only) or an exit code. SIGTERM ends it as a dive,
SIGUSR1 as the operator's key.
"""

import signal
import sys
import time
from pathlib import Path


def main(file):
    order = Path(file).read_text()
    if order.isdecimal():
        return int(order)
    # Here, as half of the starts need none of it.
    from subsea.base.interrupts import INTERRUPTED
    from subsea.stage.service import PictureReports

    signal.signal(signal.SIGTERM, lambda *_: sys.exit(INTERRUPTED))
    signal.signal(signal.SIGUSR1, lambda *_: sys.exit(0))
    reports, pictures = PictureReports(), 0
    while True:
        pictures += order == "run" or pictures == 0
        reports.update(pictures, "stand-in")
        time.sleep(0.05)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
