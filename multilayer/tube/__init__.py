"""Raw data of impedance tubes: files that describe them, and what follows for the sample."""
