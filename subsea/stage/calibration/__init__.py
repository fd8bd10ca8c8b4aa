"""Calibrate a theatre by photographs of structured light."""
