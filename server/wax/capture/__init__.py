"""Sources: cameras, microphones, files and the test card, each read in a thread of its own.

A picture or a sound leaves here with the time of its capture. Nothing is encoded here, and
nobody here knows of viewers.
"""
