"""Plugins: lists of what is registered, plugins in single files, commands of plugins, skeletons of new packages."""
