"""Processes, Dask and work beside the main thread."""
