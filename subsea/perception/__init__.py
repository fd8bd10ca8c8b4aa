"""Perception: sight, smell, lateral line, and attention."""
