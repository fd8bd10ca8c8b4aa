"""Body frame, rotations, B-splines and skin: pure functions without state."""
