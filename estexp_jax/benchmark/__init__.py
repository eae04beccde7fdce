"""Measures this machine's speed, side by side with the serial baseline."""
