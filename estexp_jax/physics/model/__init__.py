"""The robot: MJCF files, validation, names and indices, derived constants, collision pairs, scales."""
