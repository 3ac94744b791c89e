"""Raw data of impedance tubes: files that describe them, and their evaluation by ISO 10534-2 and ASTM E2611."""
