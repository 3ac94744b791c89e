"""Campaigns and recordings as they come from the laboratory; one reader per file format."""
