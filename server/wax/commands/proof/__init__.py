"""`wax prove-stop`: cut each link of the real installation in turn, and measure until it stands.

It starts a server of its own on the host's configuration. Nothing in the server imports it.
"""
