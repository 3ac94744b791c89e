"""A local page on which a stack is changed while its curves follow: what it shows, and the server that shows it."""
