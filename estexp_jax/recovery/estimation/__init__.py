"""The estimation phase: damage hypotheses judged by how well they reproduce the trials."""
