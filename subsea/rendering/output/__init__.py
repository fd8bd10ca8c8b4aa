"""From linear light to the screen."""
