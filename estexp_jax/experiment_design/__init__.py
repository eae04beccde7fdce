"""Which motion to record next: proposals, predictive simulation, excitation."""
