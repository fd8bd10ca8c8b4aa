"""Compiled kernels: the cache on disk, struct references, warm-up."""
