"""Environments for learning, by the conventions of Gymnasium and PettingZoo.

Importing this package registers `subsea/Swim-v0`, `subsea/Forage-v0` and `subsea/Escape-v0`, as
Gymnasium asks since its version 1.0, which no longer looks for entry points.
"""

from subsea.core.extras import require

require("learn", "environments")

import gymnasium  # noqa: E402

for _name in ("Swim", "Forage", "Escape"):
    gymnasium.register(
        f"subsea/{_name}-v0", entry_point=f"subsea.environments.{_name.lower()}:{_name}Env"
    )
