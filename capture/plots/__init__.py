"""Draw recorded motion as PNG pages (matplotlib)."""
