"""Every message between page and server, defined once; the page's types are generated from these.

Only models and their compact form: no decisions, no state, no imports from other packages.
"""
