"""Plan a theatre: projectors, overlaps and first meshes from a few measures of the room."""
