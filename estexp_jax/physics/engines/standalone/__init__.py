"""What was found as one file of plain MuJoCo and NumPy, which needs nothing of this package."""
