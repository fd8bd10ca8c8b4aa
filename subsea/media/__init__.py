"""Films, pictures, and what fishes see as labelled frames."""
