"""Labelled pictures of any camera, and sets of them for detectors, trackers and pose heads."""
