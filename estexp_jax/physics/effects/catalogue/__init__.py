"""The named effects, one a file."""
