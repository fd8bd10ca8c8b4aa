"""The vessel that the visitor steers."""
