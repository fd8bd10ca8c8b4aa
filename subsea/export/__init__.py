"""Export a species and its recorded motion to formats of other programs."""
