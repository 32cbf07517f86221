"""The messages between page and server, defined once."""
