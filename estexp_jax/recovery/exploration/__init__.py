"""The exploration phase: controllers evolved for the robot as diagnosed."""
