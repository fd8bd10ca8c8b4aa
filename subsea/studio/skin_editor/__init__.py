"""`subsea skin PHOTO`: a skin from a photograph, by hand (Tu §5.2.1)."""
