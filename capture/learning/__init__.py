"""Search for the motor controllers of a body (Tu §11.2, KS §I.D)."""
