"""Theatres: screens of any shape, the projectors that light them, and how their pictures meet."""
