"""From measurements to material properties: moduli burst by burst or by one law, and fields of stacks."""
