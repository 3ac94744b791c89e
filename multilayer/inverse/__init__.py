"""Several campaigns of one material compared, and moduli at several temperatures."""
