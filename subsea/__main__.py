"""`python -m subsea …` is `subsea …`."""

import sys

from subsea.app.cli import main

sys.exit(main())
