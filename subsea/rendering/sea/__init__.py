"""Drawing the sea: water, seabed, light shafts, particles."""
