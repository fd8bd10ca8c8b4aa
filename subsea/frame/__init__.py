"""Convert a world and views to a packet, the only input of rendering."""
