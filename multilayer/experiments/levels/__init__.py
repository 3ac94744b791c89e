"""Measured levels of stacks, transmission loss and absorption, with effects that act on them."""
