"""Editing a species file without a window: drafts, draggable points, checks, a test swim."""
