"""The modulus burst by burst (Bonfiglio & Pompoli 2015)."""
