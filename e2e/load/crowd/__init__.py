"""Many browser-like viewers in a process of their own, so that their cost is not the server's.

Each is the client of the protocol: it receives without decoding, and says what a page and its
browser say, since a viewer costs a server more by what they say than by what they hear.
"""
