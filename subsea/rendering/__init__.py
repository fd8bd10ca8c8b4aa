"""Every OpenGL call."""
