"""One dive on several computers: a master and nodes that step the same world in lockstep."""
