"""What the end-to-end tests stand on: a server process, browsers, instruments."""
