"""A pendulum that rubs: what several commands are tried on."""

PENDULUM = """
<mujoco model="pendulum">
  <option timestep="0.005" integrator="implicitfast"/>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="elbow" axis="0 1 0" damping="0.02"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="0.5"/>
    </body>
  </worldbody>
  <actuator><position name="servo" joint="elbow" kp="8" forcerange="-3 3" ctrlrange="-1.5 1.5"/></actuator>
  <sensor><jointpos name="angle" joint="elbow"/></sensor>
</mujoco>
"""
EFFECT = "coulomb_friction@elbow T=0.35"
SMALL = (
    "--most",
    "1",
    "--effects",
    "coulomb_friction",
    "viscous_friction",
    "command_delay",
    "--window",
    "1",
    "--no-pictures",
)


def run(*arguments: object) -> int:
    """The exit code of a command."""
    from estexp_jax.cli.main import main

    return main([str(a) for a in arguments])
