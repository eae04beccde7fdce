"""Random MJCFs: joints, tendons, equalities, actuators, sensors and flags of all kinds that MuJoCo 4 has, at random."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import final

import mujoco

_MOST_TRIES = 50
_GEOMS = {
    "sphere": "{a:.3f}",
    "capsule": "{a:.3f} {b:.3f}",
    "cylinder": "{a:.3f} {b:.3f}",
    "box": "{a:.3f} {b:.3f} {c:.3f}",
    "ellipsoid": "{a:.3f} {b:.3f} {c:.3f}",
}
_INTEGRATORS = ("Euler", "RK4", "implicit", "implicitfast")
_DISABLED = ("constraint", "equality", "frictionloss", "limit", "contact", "spring", "damper", "gravity", "clampctrl")
_DISABLED += ("warmstart", "actuation", "refsafe", "sensor", "eulerdamp", "filterparent")
_SITE_SENSORS = ("accelerometer", "gyro", "velocimeter", "force", "torque", "magnetometer", "touch")
_FRAME_SENSORS = ("framepos", "framequat", "framelinvel", "frameangvel", "framelinacc", "frameangacc", "framexaxis")


@final
@dataclass
class _Drawn:
    """Elements that were drawn so far, by what others refer to."""

    scalar: list[str] = field(default_factory=list)
    ball: list[str] = field(default_factory=list)
    sites: list[str] = field(default_factory=list)
    bodies: list[str] = field(default_factory=list)
    geoms: list[str] = field(default_factory=list)
    tendons: list[str] = field(default_factory=list)
    actuators: list[str] = field(default_factory=list)


def random_mjcf(seed: int) -> tuple[str, mujoco.MjModel]:
    """An MJCF that MuJoCo loads, and with at least one joint, by seed; what MuJoCo refuses is drawn again."""
    rng = random.Random(f"random models {seed}")
    for _ in range(_MOST_TRIES):
        text = _model(rng)
        try:
            return text, mujoco.MjModel.from_xml_string(text)
        except ValueError:
            continue
    raise RuntimeError(f"MuJoCo refuses all that is drawn from seed {seed}")


def _model(rng: random.Random) -> str:
    drawn = _Drawn()
    floor = '<geom name="floor" type="plane" size="3 3 .1"/>' if rng.random() < 0.6 else ""
    bodies = "".join(_body(rng, drawn, depth=0) for _ in range(rng.randint(1, 2)))
    tendons, equalities = _tendons(rng, drawn), _equalities(rng, drawn)
    actuators = "".join(_actuator(rng, drawn, k) for k in range(rng.randint(1, 4)))
    sensors = "".join(_sensor(rng, drawn) for _ in range(rng.randint(0, 5)))
    return (
        f'<mujoco model="drawn"><compiler angle="radian" autolimits="true"/>{_option(rng)}'
        f'<worldbody>{floor}<site name="fixed" pos="0 0 1.5"/>{bodies}</worldbody>'
        f"<tendon>{tendons}</tendon><equality>{equalities}</equality>"
        f"<actuator>{actuators}</actuator><sensor>{sensors}</sensor></mujoco>"
    )


def _option(rng: random.Random) -> str:
    chosen = {
        "timestep": str(rng.choice((0.001, 0.002, 0.004))),
        "integrator": rng.choice(_INTEGRATORS),
        "solver": rng.choice(("Newton", "Newton", "CG", "PGS")),
        "cone": rng.choice(("pyramidal", "elliptic")),
    }
    for name, values, share in (
        ("density", "1.2", 0.15),
        ("viscosity", "0.1", 0.15),
        ("wind", "1 0 0", 0.1),
        ("impratio", "5", 0.15),
        ("noslip_iterations", "3", 0.1),
        ("actuatorgroupdisable", "1", 0.2),
    ):
        chosen |= {name: values} if rng.random() < share else {}
    off = [name for name in _DISABLED if rng.random() < 0.04]
    flags = "".join(f' {name}="disable"' for name in off) + (' energy="enable"' if rng.random() < 0.2 else "")
    return f"<option {_attributes(chosen)}><flag{flags}/></option>"


def _body(rng: random.Random, drawn: _Drawn, depth: int) -> str:
    name = f"body{len(drawn.bodies)}"
    drawn.bodies.append(name)
    place = f"{_number(rng, 0.4)} {_number(rng, 0.4)} {1.0 + _number(rng, 0.3):.3f}" if depth == 0 else "0 0 -.3"
    more = _some(rng, {"gravcomp": f"{rng.random():.2f}"}, 0.15)
    joints = _joints(rng, drawn, depth)
    geoms = "".join(_geom(rng, drawn) for _ in range(rng.randint(1, 2)))
    sites = "".join(_site(rng, drawn) for _ in range(rng.randint(1, 2)))
    children = rng.choice((0, 1, 1, 2)) if depth < 3 else 0
    inside = "".join(_body(rng, drawn, depth + 1) for _ in range(children))
    return f'<body name="{name}" pos="{place}" {more}>{joints}{geoms}{sites}{inside}</body>'


def _joints(rng: random.Random, drawn: _Drawn, depth: int) -> str:
    kind = rng.choice(("hinge", "hinge", "hinge", "slide", "ball", "both", "free" if depth == 0 else "hinge"))
    if kind == "free":
        return "<freejoint/>"
    kinds = ("hinge", "slide") if kind == "both" else (kind,)
    return "".join(_joint(rng, drawn, each) for each in kinds)


def _joint(rng: random.Random, drawn: _Drawn, kind: str) -> str:
    name = f"joint{len(drawn.scalar) + len(drawn.ball)}"
    (drawn.ball if kind == "ball" else drawn.scalar).append(name)
    optional = {"stiffness": f"{5 * rng.random():.2f}", "armature": f"{0.05 * rng.random():.4f}"}
    optional |= {"frictionloss": f"{0.3 * rng.random():.3f}"}
    if kind != "ball":
        optional |= {"springref": f"{_number(rng, 0.5)}", "range": "-0.8 0.9", "actuatorfrcrange": "-2 2"}
        optional |= {"ref": f"{_number(rng, 0.2)}", "margin": "0.01", "actuatorgravcomp": "true"}
    else:
        optional |= {"range": "0 0.9"}
    axis = "" if kind == "ball" else f'axis="{_number(rng, 1)} {_number(rng, 1)} {1.1 + _number(rng, 1):.3f}"'
    more = "".join(_some(rng, {key: value}, 0.3) for key, value in optional.items())
    return f'<joint name="{name}" type="{kind}" {axis} damping="{rng.random():.3f}" {more}/>'


def _geom(rng: random.Random, drawn: _Drawn) -> str:
    name, kind = f"geom{len(drawn.geoms)}", rng.choice(list(_GEOMS))
    drawn.geoms.append(name)
    a, b, c = (0.02 + 0.08 * rng.random() for _ in range(3))
    chosen = {"condim": rng.choice("1346"), "margin": "0.005", "fluidshape": "ellipsoid", "contype": "0"}
    more = "".join(_some(rng, {key: value}, 0.2) for key, value in chosen.items())
    place = f"{_number(rng, 0.1)} {_number(rng, 0.1)} {_number(rng, 0.1)}"
    size = _GEOMS[kind].format(a=a, b=b, c=c)
    return f'<geom name="{name}" type="{kind}" size="{size}" pos="{place}" mass="{0.2 + rng.random():.3f}" {more}/>'


def _site(rng: random.Random, drawn: _Drawn) -> str:
    name = f"site{len(drawn.sites)}"
    drawn.sites.append(name)
    return f'<site name="{name}" pos="{_number(rng, 0.1)} {_number(rng, 0.1)} {_number(rng, 0.2)}"/>'


def _tendons(rng: random.Random, drawn: _Drawn) -> str:
    found = ""
    for k in range(rng.choice((0, 0, 1, 2))):
        name, optional = f"tendon{k}", {"stiffness": "4", "damping": "0.3", "frictionloss": "0.1", "armature": "0.01"}
        optional |= {"range": "-0.5 0.9", "actuatorfrcrange": "-1 1", "springlength": "0.1"}
        more = "".join(_some(rng, {key: value}, 0.3) for key, value in optional.items())
        if len(drawn.scalar) > 1 and rng.random() < 0.5:
            pair = rng.sample(drawn.scalar, 2)
            inside = "".join(f'<joint joint="{joint}" coef="{_number(rng, 2)}"/>' for joint in pair)
            found += f'<fixed name="{name}" {more}>{inside}</fixed>'
        else:
            wrap = f'<geom geom="{rng.choice(drawn.geoms)}"/>' if rng.random() < 0.3 else ""
            ends = f'<site site="fixed"/>{wrap}<site site="{rng.choice(drawn.sites)}"/>'
            found += f'<spatial name="{name}" {more}>{ends}</spatial>'
        drawn.tendons.append(name)
    return found


def _equalities(rng: random.Random, drawn: _Drawn) -> str:
    found = ""
    if len(drawn.scalar) > 1 and rng.random() < 0.3:
        one, other = rng.sample(drawn.scalar, 2)
        found += f'<joint joint1="{one}" joint2="{other}" polycoef="0 {_number(rng, 1)} 0.1 0 0"/>'
    if rng.random() < 0.15:
        found += f'<connect body1="{rng.choice(drawn.bodies)}" anchor="0 0 .1"/>'
    if len(drawn.bodies) > 1 and rng.random() < 0.1:
        one, other = rng.sample(drawn.bodies, 2)
        found += f'<weld body1="{one}" body2="{other}"/>'
    if len(drawn.tendons) > 1 and rng.random() < 0.4:
        found += '<tendon tendon1="tendon0" tendon2="tendon1"/>'
    return found


def _transmission(rng: random.Random, drawn: _Drawn) -> str:
    options: list[Callable[[], str]] = []
    if drawn.scalar:
        options += [lambda: f'joint="{rng.choice(drawn.scalar)}" gear="{0.5 + 2 * rng.random():.2f}"'] * 4
    if drawn.ball:
        options += [lambda: f'joint="{rng.choice(drawn.ball)}" gear="{_number(rng, 1)} {_number(rng, 1)} 1"']
        options += [lambda: f'jointinparent="{rng.choice(drawn.ball)}" gear="1 0 0"']
    if drawn.tendons:
        options += [lambda: f'tendon="{rng.choice(drawn.tendons)}"'] * 2
    options += [lambda: f'site="{rng.choice(drawn.sites)}" gear="0 0 1 0 {_number(rng, 1)} 0"']
    options += [lambda: f'site="{rng.choice(drawn.sites)}" refsite="fixed" gear="1 0 0 0 0 0"']
    return rng.choice(options)()


def _actuator(rng: random.Random, drawn: _Drawn, index: int) -> str:
    name = f"motor{index}"
    drawn.actuators.append(name)
    kind = rng.choice(list(_ACTUATORS))
    optional = {"ctrlrange": "-1 1", "forcerange": "-3 3", "group": "1", "delay": ".008"}
    if kind in ("intvelocity", "damper"):
        optional.pop("ctrlrange")
    if kind == "adhesion":
        return f'<adhesion name="{name}" body="{rng.choice(drawn.bodies)}" gain="5" ctrlrange="0 1"/>'
    more = "".join(_some(rng, {key: value}, 0.25) for key, value in optional.items())
    more = more.replace('delay=".008"', 'delay=".008" nsample="4"')
    if kind == "orientation":
        where = f'joint="{rng.choice(drawn.ball)}"' if drawn.ball else 'joint="none"'
        return f'<orientation name="{name}" {where} kp="20" {rng.choice(("", "input=" + chr(34) + "quat" + chr(34)))}/>'
    return f'<{kind.split()[0]} name="{name}" {_transmission(rng, drawn)} {_ACTUATORS[kind]} {more}/>'


_ACTUATORS = {
    "motor": "",
    "position": 'kp="20" kv="1"',
    "position timeconst": 'kp="20" timeconst=".02"',
    "position dampratio": 'kp="20" dampratio="1" inheritrange="0"',
    "velocity": 'kv="3"',
    "intvelocity": 'kp="20" kv="1" actrange="-.6 .6"',
    "damper": 'kv="2" ctrlrange="0 1"',
    "cylinder": 'timeconst=".05" area="2" bias="0 -1 -.1"',
    "muscle": 'lengthrange="-1 1" force="10"',
    "general filter": 'dyntype="filter" dynprm=".03" gainprm="4"',
    "general filterexact early": 'dyntype="filterexact" dynprm=".03" gainprm="4" actearly="true"',
    "general integrator": (
        'dyntype="integrator" gainprm="10" biastype="affine" biasprm="0 -10 -1" actlimited="true" actrange="-.5 .5"'
    ),
    "general affine": 'gaintype="affine" gainprm="3 .2 -.1" biastype="affine" biasprm=".1 -2 -.2"',
    "adhesion": "",
    "pid": 'kp="20" kv="1"',
    "pid velocity": 'kp="0" kv="3" input="vel"',
    "orientation": "",
    "dcmotor": 'resistance="1" motorconst=".5"',
    "dcmotor none": 'resistance="1" motorconst=".5" input="none"',
}


def _sensor(rng: random.Random, drawn: _Drawn) -> str:
    more = _some(rng, {"cutoff": "1"}, 0.15)
    if rng.random() < 0.2:
        more += ' delay=".008" nsample="4"' if rng.random() < 0.5 else ' interval=".008" nsample="2"'
    options = [f'<{rng.choice(_SITE_SENSORS)} site="{rng.choice(drawn.sites)}" {more}/>']
    frame = rng.choice(_FRAME_SENSORS)
    options += [f'<{frame} objtype="site" objname="{rng.choice(drawn.sites)}" {more}/>']
    options += [f'<subtreecom body="{rng.choice(drawn.bodies)}" {more}/>']
    if drawn.scalar:
        joint = rng.choice(drawn.scalar)
        kinds = ("jointpos", "jointvel", "jointactuatorfrc", "jointlimitpos", "jointlimitfrc")
        options += [f'<{rng.choice(kinds)} joint="{joint}" {more}/>'] * 3
    if drawn.ball:
        options += [f'<{rng.choice(("ballquat", "ballangvel"))} joint="{rng.choice(drawn.ball)}" {more}/>']
    if drawn.tendons:
        options += [f'<{rng.choice(("tendonpos", "tendonvel"))} tendon="{rng.choice(drawn.tendons)}" {more}/>']
    actuator = rng.choice(drawn.actuators)
    options += [f'<{rng.choice(("actuatorpos", "actuatorvel", "actuatorfrc"))} actuator="{actuator}" {more}/>'] * 2
    options += [f"<clock {more}/>"]
    return rng.choice(options)


def _some(rng: random.Random, attributes: dict[str, str], share: float) -> str:
    return _attributes(attributes) + " " if rng.random() < share else ""


def _attributes(values: dict[str, str]) -> str:
    return " ".join(f'{name}="{value}"' for name, value in values.items())


def _number(rng: random.Random, most: float) -> float:
    return round(rng.uniform(-most, most), 3)
