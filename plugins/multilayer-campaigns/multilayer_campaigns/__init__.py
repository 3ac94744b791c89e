"""Campaigns of one material compared: under several static loads, along three axes; moduli of several temperatures."""
