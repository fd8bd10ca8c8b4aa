"""Window, input, clock, overlay, film, benchmark and command line."""
