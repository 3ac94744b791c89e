"""The diagnosis of impedance tubes: data, hypothesis, file."""
