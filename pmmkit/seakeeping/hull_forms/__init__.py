"""Hulls in sections: from offsets, from particulars, by name."""
