"""The presenter's console: a page, an HTTP and an OSC interface to a running dive.

It knows no dive: both sides meet at the board (`board.py`), the dive between two frames.
"""
