"""Behavior: desires, intentions, and routines that set goals for the motor system."""
