"""Figures and pages: functions of results; drawing libraries are imported where they draw."""
