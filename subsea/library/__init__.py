"""The functions and classes of `import subsea`."""
