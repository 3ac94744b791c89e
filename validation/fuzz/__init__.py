"""Input that nobody means, by the thousand: mutated files, flipped bits, extreme numbers, sizes; see `__main__`."""
