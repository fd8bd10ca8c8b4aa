"""The environments for learning under the name that programs import: `subsea.lab.environments`."""

import sys

from subsea.lab import environments

sys.modules[__name__] = environments
