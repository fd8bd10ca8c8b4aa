"""Drawing fishes."""
