"""The computers and projectors of a theatre: their state, restarts, power and updates."""
