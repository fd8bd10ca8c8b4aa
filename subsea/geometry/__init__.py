"""Geometry: vectors, rotations, splines, noise, height fields, solids. Pure functions."""
