"""Scenarios: read, save and look up the inhabitants of a sea."""
