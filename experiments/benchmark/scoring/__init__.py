"""Scores of explained cases against their answers: pure functions of two JSON objects a case."""
