"""Scenarios: who lives where, read, saved and looked up."""
