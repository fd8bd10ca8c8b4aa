"""The pose of what is visible, as plain numpy: the oracle for the shaders."""
