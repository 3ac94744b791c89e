"""Time signals of the two-plate rig: bursts, spectra, envelopes, times of flight, calibration, quality."""
