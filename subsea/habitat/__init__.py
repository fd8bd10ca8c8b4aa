"""Where the fishes live: terrain, current, plankton."""
