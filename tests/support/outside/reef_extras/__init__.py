"""What somebody else adds to subsea: a command, a part of a dive, a format of theatres."""
