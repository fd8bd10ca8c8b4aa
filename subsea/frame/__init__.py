"""World and views in, packet out: all that drawing sees of the world."""
