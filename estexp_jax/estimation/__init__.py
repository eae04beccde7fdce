"""State estimation from recordings: windows, initial states, smoothing, noise, accuracy."""
