"""Sources: cameras, microphones, files and the test card, each read in its own thread.

Pictures and sounds carry their capture time; each source says itself when its device is silent.
Nothing here encodes or knows about viewers.
"""
