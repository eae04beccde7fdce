"""Other methods on the same cases; they see the same files, and share no code with the package."""
