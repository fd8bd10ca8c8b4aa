"""What somebody else adds: a command, a part of a dive, a format of theatres, a behavior."""
