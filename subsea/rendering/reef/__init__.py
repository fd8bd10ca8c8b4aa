"""Drawing the reef: corals, rocks, seaweed."""
