"""Writing to disk: what is replaced is, at every instant, the old or the new one, as a whole."""
