"""Perception: what a fish sees, smells and feels, and what it attends to."""
