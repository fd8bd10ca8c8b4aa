"""The sound of a sea: from its state and a listener to samples.

Nothing here draws or opens a window; `device` alone plays sound.
"""
