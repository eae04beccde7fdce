"""First files to be completed by hand: a recordings.toml for logs, an MJCF for a robot without motors and sensors."""
