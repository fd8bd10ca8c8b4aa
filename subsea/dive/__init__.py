"""A dive without its windows: clock, ticks, pilot, tours, settings."""
