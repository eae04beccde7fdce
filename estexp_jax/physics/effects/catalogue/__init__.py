"""The named effects, one a file; loading this folder registers them in the order below."""

from importlib import import_module

EFFECTS = (
    "viscous_friction",
    "coulomb_friction",
    "stribeck_friction",
    "load_dependent_friction",
    "quadratic_drag",
    "joint_stiffness",
    "cogging",
    "armature",
    "joint_limit",
    "joint_jam",
    "hysteresis",
    "crosstalk",
    "torque_offset",
    "gravity_compensation",
    "motor_weakness",
    "torque_saturation",
    "back_emf",
    "motor_fade",
    "supply_sag",
    "joint_compliance",
    "backlash",
    "command_delay",
    "command_limit",
    "actuator_lag",
    "dead_band",
    "tied_outputs",
    "sensor_gain",
    "sensor_bias",
    "sensor_delay",
    "sensor_stuck",
    "body_mass",
    "com_shift",
    "joint_offset",
    "part_lost",
    "gravity_tilt",
    "ground_friction",
    "external_force",
    "mount_compliance",
    "channels_exchanged",
    "no_signal",
    "clock_scale",
    "command_lead",
    "neuron_fault",
)
"""Modules of the catalogue. Terms act in this order: what changes a motor's torque, then what passes it on."""

FORMS = (
    "stribeck_bristles",
    "load_bristles",
    "servo_damping",
    "part_stub",
    "outer_compliance",
    "outer_backlash",
    "rotor_backlash",
    "rebound_limit",
    "motor_heat",
    "supply_floor",
    "asymmetric_friction",
    "smooth_friction",
    "asymmetric_damping",
)
"""Modules of other forms of these effects, reported under their names."""

for _module in (*EFFECTS, *FORMS):
    import_module(f"{__name__}.{_module}")
