"""Cues of a theatre: lamps of the room, messages to desks, timecode and MIDI."""
