"""The system of 2004, kept as the baseline: the thesis's algorithm (3.3) and its µ-law sound.

`unit_sender` decides for one viewer what leaves when (pure, as are its parts); `streams` serves
viewers with it behind the same interface as the live service. Nothing of today uses it.
"""
