"""What all stages share: errors, files, caches, compiled kernels."""
