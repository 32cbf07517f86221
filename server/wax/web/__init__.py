"""HTTP: the built page, and the few requests that cannot use a data channel.

Handlers parse a request and call the session; they decide nothing.
"""
