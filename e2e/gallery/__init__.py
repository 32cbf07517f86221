"""Every state of the page, reached for real: a picture of each, and what holds in all."""
