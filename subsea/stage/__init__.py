"""Exhibitions: theatres, clusters, consoles, shows, kiosks and headsets."""
