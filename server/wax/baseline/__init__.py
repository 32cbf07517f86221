"""The system of 2004 as a baseline: the thesis's algorithm (3.3) and its µ-law sound.

`unit_sender` decides what leaves when for one viewer (pure, like its parts); `streams` serves
viewers with it behind the same interface as the live service, which does not use it.
"""
