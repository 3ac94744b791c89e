"""Earlier methods: the transfer function of a rod, the quasi-static method, and all methods side by side."""
