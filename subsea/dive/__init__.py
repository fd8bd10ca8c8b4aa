"""A dive without windows: clock, ticks, pilot, tours, settings."""
