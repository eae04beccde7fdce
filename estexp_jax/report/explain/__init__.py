"""Figures and the page of an explanation."""
