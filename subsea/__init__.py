"""A virtual submarine among artificial fishes."""

__version__ = "0.2.0"
