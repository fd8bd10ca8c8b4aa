"""Motion of a fish: playback of captured segments, gliding, balancing, fins."""
