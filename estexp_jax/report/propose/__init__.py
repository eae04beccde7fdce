"""Figures, advice and page of a proposed experiment."""
