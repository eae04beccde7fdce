"""One small robot for each feature of MuJoCo that engines treat differently."""

_HEAD = '<mujoco><option timestep="0.004" integrator="{integrator}" {option}/>'
_ARM = """
<worldbody>{world}<body name="upper" pos="0 0 1"><joint name="shoulder" axis="0 1 0" damping="0.05" {joint}/>
<geom name="upper" type="capsule" size=".03" fromto="0 0 0 .3 0 0" mass=".8" {geom}/>
<body name="lower" pos=".3 0 0" {body}><joint name="elbow" axis="0 1 0" damping="0.05"/>
<geom name="lower" type="capsule" size=".02" fromto="0 0 0 .25 0 0" mass=".4" {geom}/><site name="hand" pos=".25 0 0"/>
</body></body></worldbody>{more}
<actuator>{actuators}</actuator><sensor><jointpos joint="shoulder"/><jointpos name="bend" joint="elbow" {sensor}/>
<accelerometer site="hand"/></sensor></mujoco>
"""
_SERVOS = '<position joint="shoulder" kp="60" kv="6"/><position joint="elbow" kp="30" kv="2"/>'
_TENDON = (
    '<tendon><fixed name="both" {}><joint joint="shoulder" coef="1"/><joint joint="elbow" coef="-2"/></fixed></tendon>'
)
_BALL = """
<worldbody><body pos="0 0 1"><joint name="neck" type="ball" damping=".3"/>
<geom type="capsule" size=".05" fromto="0 0 0 0 0 .25" mass="2"/><site name="imu" pos="0 0 .3"/></body></worldbody>
<actuator>{}</actuator><sensor><ballquat joint="neck"/><accelerometer site="imu"/></sensor></mujoco>
"""
_LONE = """
<worldbody><body name="thrown" pos="0 0 1"><freejoint name="root"/>
<geom type="box" size=".1 .05 .02" mass="1"/></body></worldbody>
<sensor><framequat objtype="body" objname="thrown"/></sensor></mujoco>
"""


def _arm(integrator: str = "implicitfast", **what: str) -> str:
    plain = {"option": "", "world": "", "joint": "", "geom": 'contype="0" conaffinity="0"', "body": "", "more": ""}
    text = plain | {"actuators": _SERVOS, "sensor": "", "integrator": integrator} | what
    return (_HEAD + _ARM).format(**text)


def _ball(actuators: str) -> str:
    return _HEAD.format(integrator="implicitfast", option="") + _BALL.format(actuators)


_FLOOR = '<geom name="floor" type="plane" size="2 2 .1" pos="0 0 .85"/>'
_ROUND = '<position joint="neck" gear="1 0 0" kp="40" kv="3"/>'
_PULLED = f'{_SERVOS}<position tendon="both" kp="20" kv="1" {{}}/>'

FEATURES = {
    "servos at hinges": _arm(),
    "force range of a servo": _arm(actuators=_SERVOS.replace('kv="6"', 'kv="6" forcerange="-6 6"')),
    "disabled group of actuators": _arm(
        option='actuatorgroupdisable="1"', actuators=_SERVOS.replace('"6"', '"6" group="1"')
    ),
    "force range of a joint (actuatorfrcrange)": _arm(joint='actuatorfrcrange="-6 6"'),
    "fixed tendon": _arm(more=_TENDON.format('stiffness="2"'), actuators=_PULLED.format("")),
    "force range of a tendon": _arm(more=_TENDON.format('actuatorfrcrange="-1 1"'), actuators=_PULLED.format("")),
    "force range of a servo at a tendon": _arm(more=_TENDON.format(""), actuators=_PULLED.format('forcerange="-1 1"')),
    "mimic joint (equality)": _arm(more='<equality><joint joint1="elbow" joint2="shoulder"/></equality>'),
    "spring that yields": _arm(joint='stiffness="20" springyield="1"'),
    "gravity compensation (gravcomp)": _arm(body='gravcomp="1"'),
    "fluid, ellipsoid model": _arm("Euler", option='density="1.2" viscosity=".1"', geom='fluidshape="ellipsoid"'),
    "activation before force (actearly)": _arm(
        actuators='<general joint="shoulder" dyntype="filter" dynprm=".02" gainprm="9" actearly="true"/>'
    ),
    "activation of its own": _arm(actuators='<general joint="shoulder" dyntype="filter" dynprm=".02" gainprm="9"/>'),
    "muscle": _arm(actuators='<muscle joint="shoulder" lengthrange="-1 1" force="20"/>', joint='range="-60 60"'),
    "delay of an actuator": _arm(actuators=_SERVOS.replace('kv="6"', 'kv="6" delay=".008" nsample="2"')),
    "delay of a sensor": _arm(sensor='delay=".004" nsample="1"'),
    "interval of a sensor": _arm(sensor='interval=".008" nsample="1"'),
    "ball joint, accelerometer": _ball(_ROUND),
    "orientation servo": _ball('<orientation joint="neck" kp="30"/>'),
    "PID controller": _arm(actuators='<pid joint="shoulder" kp="30" kv="2"/>'),
    "delay beyond its buffer, RK4": _arm("RK4", actuators=_SERVOS.replace('kv="6"', 'kv="6" delay=".02" nsample="2"')),
    "delay of a PID controller": _arm(
        actuators='<pid joint="shoulder" kp="30" kv="2" delay=".008" nsample="2"/><motor joint="elbow"/>'
    ),
    "motor without input": _arm(actuators='<dcmotor joint="elbow" resistance="1" motorconst=".5" input="none"/>'),
    "lone free body, Euler": _HEAD.format(integrator="Euler", option="") + _LONE,
    "contacts with a plane": _arm(world=_FLOOR, geom='contype="2" conaffinity="1"'),
    "contacts between capsules": _arm(geom='contype="1" conaffinity="1" margin=".01"').replace(
        "</body></body></worldbody>",
        "</body></body><body pos='.2 0 .8'><geom type='capsule' size='.05 .3'/></body></worldbody>",
    ),
}
