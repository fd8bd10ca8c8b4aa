"""How a fish moves: playback of captured segments, gliding, balancing, fins."""
