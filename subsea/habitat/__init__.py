"""The habitat: seabed, rocks, reefs, seaweed, plankton, current and the hook."""
