"""Shared basics: errors, files, caches, compiled kernels."""
