"""Figures and tables that a person looks at, and how files are written."""
