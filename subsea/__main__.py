"""`python -m subsea …` is `subsea …`."""

import sys

from subsea.cli.main import main

sys.exit(main())
