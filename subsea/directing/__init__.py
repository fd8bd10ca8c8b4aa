"""Directions of a scenario: what is to happen in its world, and when (Tu §11.6.1)."""
