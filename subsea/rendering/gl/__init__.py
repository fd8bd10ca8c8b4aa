"""OpenGL basics: contexts, shaders, textures, batches, the id buffer."""
