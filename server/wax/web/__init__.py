"""HTTP: the built page, and the few requests that come before there is a data channel.

Handlers read a request and ask the session; they decide nothing.
"""
