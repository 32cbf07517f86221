"""HTTP: the built page, and the few requests that come before there is a data channel."""
