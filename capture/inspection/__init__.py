"""Measure recorded motion and compare it with targets."""
