"""One dive on several computers: a master and the nodes that step the same world with it."""
