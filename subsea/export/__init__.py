"""Export a species and its recorded motion to formats of other programs."""

# Packings of the arrays of a glTF file.
PLAIN, QUANTISED, MESHOPT = "none", "quantised", "meshopt"
COMPRESSIONS = (PLAIN, QUANTISED, MESHOPT)
