"""Files behind URLs: which URLs are read, and the copies of what stands behind them.

Readers need files, so an object is copied whole into a folder of this machine before it is read,
once for each state of it. Workers on other machines copy for themselves. Nothing of a URL is given
to fsspec before it was seen to be a plain one: no chains of protocols and none that lead to files
of this machine. fsspec is imported where a URL is read.
"""
