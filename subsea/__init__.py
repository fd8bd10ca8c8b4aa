"""A virtual submarine among artificial fishes."""
