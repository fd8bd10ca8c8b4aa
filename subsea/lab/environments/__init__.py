"""Environments for learning, by the conventions of Gymnasium and PettingZoo.

Importing this package registers `subsea/Swim-v0`, `subsea/Forage-v0` and `subsea/Escape-v0`, as
Gymnasium asks since its version 1.0, which no longer looks for entry points.
"""

from subsea.base.system import require

require("learn", "environments")

import gymnasium  # noqa: E402

gymnasium.register(
    "subsea/Swim-v0",
    entry_point="subsea.lab.environments.swim:SwimEnv",
    vector_entry_point="subsea.lab.environments.swim:SwimVectorEnv",
    max_episode_steps=300,
)
for _name in ("Forage", "Escape"):
    gymnasium.register(
        f"subsea/{_name}-v0", entry_point=f"subsea.lab.environments.steered_fish:{_name}Env"
    )

from subsea.lab.environments.showing import RecordVideo as RecordVideo  # noqa: E402
