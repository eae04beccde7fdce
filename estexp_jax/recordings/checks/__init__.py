"""Checks of recordings that need no simulation: clock, units, saturation, excitation, servo faults."""
