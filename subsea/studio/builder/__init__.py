"""The fish builder: a species' body, scaffold and motion drawn by hand (KS I.B)."""
