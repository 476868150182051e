"""The form of MSC/Circ.1053, appendix 6, for a model or for the trials of a ship."""
