"""Fields of stacks from any measurements of them."""
