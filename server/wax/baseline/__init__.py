"""Pure: the synchronisation algorithm of the thesis, chapter 3.3, as it was in 2004.

`Sender` decides for one viewer what leaves when; the rest are the parts that it is made of.
"""
