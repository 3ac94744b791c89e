"""Measurements of stacks: what a file says of them, what a stack predicts, and which fields are unknown."""
