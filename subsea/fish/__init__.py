"""What a fish is: its surface, mesh, colours, spine and species file."""
