"""Directions of a scenario: scheduled events in its world (Tu §11.6.1)."""
