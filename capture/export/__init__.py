"""A species and its recorded motion in the formats of other programs."""
