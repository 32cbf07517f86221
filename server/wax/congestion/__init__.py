"""Congestion control for one viewer's link: its rate, what to send, and when. Pure.

README.md draws it, and says which part is there for what. `sync/` decides when media play.
"""
