"""Environments for learning: Gymnasium's and PettingZoo's conventions over bodies and seas."""


def register() -> None:
    """Register the environments; Gymnasium calls this when it is imported."""
    from gymnasium import register as add

    for name in ("Swim", "Forage", "Escape"):
        add(f"{name}-v0", entry_point=f"subsea.environments.{name.lower()}:{name}Env")
