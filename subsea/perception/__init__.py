"""What a fish knows of its neighbours."""
