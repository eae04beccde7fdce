"""Concealed recordings, by another hand: nothing here comes from the package that has to explain them.

Only numpy, scipy and mujoco are imported (a test sees to it). Robots are simulated by the C engine at a tenth of the
nominal step with another integrator, or by equations of motion written out by hand; effects are hidden states and
forces of our own.
"""
