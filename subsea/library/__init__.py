"""What `import subsea` offers."""
