"""The skin of a fish: the mesh over its control points, and the sheet of colours on it."""
