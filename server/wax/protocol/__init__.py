"""Every message between page and server, defined once; the page's types are made from these.

Nothing but models and their compact form: no decisions, no state, no imports from other packages.
"""
