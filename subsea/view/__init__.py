"""Cameras, frusta, culling and levels of detail: lists of views, no OpenGL."""
