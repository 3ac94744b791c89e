"""Plugins: what is registered and by whom, single files that register more, skeletons of new packages."""
