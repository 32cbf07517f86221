"""Every message between page and server, defined once; the page's types are generated from these.

It has only models and their encoding: no decisions and no state.
"""
