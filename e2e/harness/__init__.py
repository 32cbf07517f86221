"""The end-to-end tests' server process, browsers and instruments."""
