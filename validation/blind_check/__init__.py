"""How often the diagnosis is right, on campaigns of the virtual rig whose effects it is not told."""
