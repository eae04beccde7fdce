"""The exchange with a robot in the world: controllers as plain arrays, logs as trials."""
