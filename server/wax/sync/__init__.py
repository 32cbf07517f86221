"""Synchronisation: the sound is the master (thesis 3.3), or neither waits (`video_first`).

Pure: it takes `now_s` and returns targets for the page's jitter buffers, without input or output.
"""
