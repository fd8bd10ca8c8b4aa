"""Swim the simulated fish, record its motion and write repertoires (SMC §4)."""
