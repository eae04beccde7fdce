"""Figures and pages as functions of results; drawing libraries are imported where they are used."""
