"""Films, pictures, and labelled frames of the views of fishes."""
