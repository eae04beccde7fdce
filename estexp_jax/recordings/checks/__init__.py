"""What is judged of recordings before anything is simulated: clock, units, saturation, excitation, servo faults."""
