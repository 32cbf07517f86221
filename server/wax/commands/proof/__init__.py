"""`wax prove-stop`: cuts each link of the real installation, and measures how it stops.

It starts a server of its own with the host's configuration. Nothing in the server imports it.
"""
