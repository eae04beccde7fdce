"""Figure, film, files and page of a recovery."""
