"""What a robot is to WAX."""
