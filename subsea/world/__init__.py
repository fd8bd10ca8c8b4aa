"""A world: how it begins, advances by a tick, and is saved."""
