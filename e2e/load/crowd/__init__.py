"""Many browser-like viewers in a process of their own, so that their cost is not the server's.

Each is the client of the protocol: it receives without decoding, and sends what a page and its
browser send, since a viewer's messages cost a server more than what it receives.
"""
