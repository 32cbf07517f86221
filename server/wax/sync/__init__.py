"""Synchronisation: the sound is the master (thesis 3.3), or neither waits (`video_first`).

Pure: takes `now_s`, returns targets for the page's jitter buffers. No input or output.
"""
