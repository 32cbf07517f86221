"""The configuration: every key with its range and default."""
