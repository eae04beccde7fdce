"""A robot whose actuators have three inputs, two, one, and none."""

MIXED = """
<mujoco><option timestep="0.004" integrator="implicitfast"/><worldbody>
<body pos="0 0 1"><joint name="neck" type="ball" damping="0.1"/><geom type="capsule" size=".03" fromto="0 0 0 .1 0 0"
mass=".5"/>
<body pos=".1 0 0"><joint name="elbow" axis="0 1 0" damping="0.1"/>
<geom type="capsule" size=".03" fromto="0 0 0 .2 0 0" mass=".3"/>
<body pos=".2 0 0"><joint name="wrist" axis="0 1 0" damping="0.05"/>
<geom type="capsule" size=".02" fromto="0 0 0 .1 0 0" mass=".2"/><site name="hand"/></body></body></body></worldbody>
<actuator><orientation name="turn" kp="30" joint="neck"/><dcmotor name="brake" joint="elbow" resistance="1"
motorconst=".5" input="none"/><pid name="pid" joint="elbow" kp="30" kv="1"/>
<motor name="push" joint="wrist" gear="2"/>
<position name="servo" joint="wrist" kp="5" kv=".1" gear="3"/></actuator>
<sensor><ballquat name="looks" joint="neck"/><jointpos name="bends" joint="elbow"/>
<jointpos name="wrist" joint="wrist"/>
<gyro name="gyro" site="hand"/>
<accelerometer name="felt" site="hand"/><actuatorfrc name="pull" actuator="pid"/></sensor>
</mujoco>
"""
