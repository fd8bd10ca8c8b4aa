"""Fish data: surface, mesh, colours, spine and species file."""
