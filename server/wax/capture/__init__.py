"""Sources: cameras, microphones, files and the test card, each read in its own thread.

Pictures and sounds carry their capture time; each source raises an error when its device falls
silent. Nothing here encodes or knows about viewers.
"""
