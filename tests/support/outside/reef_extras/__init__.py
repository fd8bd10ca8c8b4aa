"""A package that adds a command, a part of a dive, a format of theatres and a behavior."""
