"""Stacks for other programs: tables of what a stack does, cards of its materials; and materials from their tables."""
