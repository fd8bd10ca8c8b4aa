"""Names of the ways to store a glTF file, apart from what they need."""

PLAIN, QUANTISED, MESHOPT = "none", "quantised", "meshopt"
COMPRESSIONS = (PLAIN, QUANTISED, MESHOPT)
