"""Bad models: MJCF with damage, hostile numbers, counts without end, and ways to files that are not the model's."""

from __future__ import annotations

import random
import re
from pathlib import Path

from experiments.robustness.fuzz import draw
from experiments.robustness.fuzz.logs import MAP, good_csv

GOOD = """<mujoco model="arm">
<compiler angle="radian" meshdir="." autolimits="true"/>
<option timestep="0.002" gravity="0 0 -9.81" integrator="implicitfast"/>
<size memory="1M"/>
<default><joint damping="0.1"/><default class="c"><geom size=".1"/></default></default>
<asset><texture name="t" type="2d" builtin="flat" width="8" height="8"/><material name="m" texture="t"/></asset>
<worldbody><geom type="plane" size="1 1 .1"/><body name="upper" pos="0 0 1">
<joint name="elbow" axis="0 1 0" range="-1 1" damping="0.1" armature="0.01"/>
<geom name="g" type="capsule" class="c" fromto="0 0 0 0 0 -.3" size=".02" mass="0.5" material="m"/>
<site name="s" pos="0 0 -.3"/><body name="lower" pos="0 0 -.3"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
<joint name="wrist" type="hinge" axis="0 1 0"/><geom size=".05"/></body></body></worldbody>
<actuator><position name="servo" joint="elbow" kp="8" ctrlrange="-1 1" forcerange="-3 3"/></actuator>
<sensor><jointpos name="angle" joint="elbow"/></sensor>
<keyframe><key name="home" qpos="0 0"/></keyframe>
</mujoco>
"""
WORDS = (
    "mujoco", "body", "joint", "geom", "site", "position", "motor", "jointpos", "worldbody", "default", "elbow",
    "servo", "angle", "upper", "lower", "hinge", "free", "ball", "slide", "capsule", "mesh", "box", "-1 1", "0 1 0",
    "0.1", ".1", "radian", "degree", "size", "mass", "range", "pos", "name", "class", "0 0 -.3", "8", "1M", "0 0",
)  # fmt: skip
HUGE = (
    '<worldbody><replicate count="1000000000" offset="0 0 1"><body><geom size=".1"/></body></replicate></worldbody>',
    '<worldbody><replicate count="3000"><replicate count="3000"><geom size=".1"/></replicate></replicate></worldbody>',
    '<worldbody><body><composite type="grid" count="99999 99999 1" spacing=".1"><geom size=".1"/></composite></body>'
    "</worldbody>",
    '<worldbody><body><flexcomp name="f" type="grid" count="3000 3000 3000" spacing=".1 .1 .1" dim="3"/></body>'
    "</worldbody>",
    '<asset><texture name="u" type="2d" builtin="flat" width="2000000000" height="2000000000"/></asset>',
    '<asset><texture name="u" type="2d" builtin="gradient" width="60000" height="60000"/></asset>',
    '<asset><hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/></asset>',
    '<size memory="900000G"/>',
    '<size memory="100G"/>',
    '<size nuserdata="2000000000"/>',
    '<size nuser_body="2000000000"/>',
    '<size njmax="2000000000" nconmax="2000000000"/>',
    '<size nkey="2000000000"/>',
    '<sensor><user name="z" dim="2000000000"/></sensor>',
    '<worldbody><body><geom type="sphere" size="1e308"/><joint range="nan inf" limited="true"/></body></worldbody>',
    '<option timestep="1e-300"/>',
    '<option iterations="2147483647" timestep="nan"/>',
    '<statistic meansize="nan" extent="inf"/>',
    '<keyframe><key qpos="' + "0 " * 5000 + '"/></keyframe>',
    "<worldbody>" + "<body>" * 3000 + '<geom size=".1"/>' + "</body>" * 3000 + "</worldbody>",
    '<!DOCTYPE m [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;">]>'
    '<custom><text name="x" data="&b;"/></custom>',
    '<extension><plugin plugin="mujoco.pid"><instance name="i"/></plugin></extension>',
)
"""What asks for memory or time without end, as additions to a model."""
REFERENCES = (
    '<include file="{}"/>',
    '<asset><mesh name="x" file="{}"/></asset>',
    '<asset><hfield name="x" file="{}" size="1 1 1 1"/></asset>',
    '<asset><texture name="x" type="2d" file="{}"/></asset>',
    '<asset><skin name="x" file="{}"/></asset>',
    '<asset><model name="x" file="{}"/></asset>',
    '<compiler meshdir="{}" texturedir="{}"/><asset><mesh name="x" file="passwd.obj"/></asset>',
    '<worldbody><body><flexcomp name="f" type="mesh" file="{}"/></body></worldbody>',
)
FILES = ("model.xml", "log.csv", "mesh.stl", "mesh.obj", "mesh.msh", "mesh.png", "inner.xml", *draw.PATHS)


def mjcf(source: random.Random, folder: Path) -> list[str]:
    """A model, with a good log of the robot that it should be."""
    match source.randrange(6):
        case 0:
            content = draw.mutated(source, GOOD.encode())
        case 1:
            content = draw.replaced(source, GOOD, WORDS).encode("utf-8", "surrogatepass")
        case 2:
            content = _numbers(source, GOOD).encode()
        case 3:
            content = _shuffled(source).encode()
        case 4:
            content = _added(_numbers(source, source.choice(HUGE)) if draw.chance(source, 0.7) else source.choice(HUGE))
        case _:
            content = _added(source.choice(REFERENCES).replace("{}", _escaped(source.choice(FILES))))
            _files(source, folder)
    (folder / "model.xml").write_bytes(content)
    (folder / "log.csv").write_bytes(good_csv())
    return ["check", str(folder / "model.xml"), str(folder / "log.csv"), *MAP]


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;").replace("\0", "&#0;")


def _added(element: str) -> bytes:
    return GOOD.replace("</mujoco>", f"{element}\n</mujoco>").encode()


def _numbers(source: random.Random, text: str) -> str:
    """One or two numbers of a text made others."""
    for _ in range(source.randint(1, 2)):
        found = list(re.finditer(r"(?<=[\" ])-?[\d.]+(?:e\d+)?(?=[\" M])", text))
        if found:
            spot = source.choice(found)
            text = text[: spot.start()] + source.choice(draw.NUMBERS) + text[spot.end() :]
    return text


def _shuffled(source: random.Random) -> str:
    """Lines of a model doubled, dropped or moved."""
    lines = GOOD.splitlines()
    for _ in range(source.randint(1, 3)):
        line = lines.pop(source.randrange(len(lines)))
        for _ in range(source.choice((0, 1, 2))):
            lines.insert(source.randint(0, len(lines)), line)
    return "\n".join(lines)


def _files(source: random.Random, folder: Path) -> None:
    """Files that a model may refer to, none of them good."""
    for name in ("mesh.stl", "mesh.obj", "mesh.msh", "mesh.png", "inner.xml"):
        (folder / name).write_bytes(_asset(source, name))


def _asset(source: random.Random, name: str) -> bytes:
    count = source.choice((0, 1, 3, 2**31 - 1, 2**32 - 1, 10**6))
    small = min(count, 1000)
    made = {
        "mesh.stl": b"x" * 80 + count.to_bytes(4, "little") + source.randbytes(50 * source.randint(0, 5)),
        "mesh.obj": f"v 0 0 {source.choice(draw.NUMBERS)}\nv 1 0 0\nv 0 1 nan\nf 1 2 {count}\n".encode(),
        "mesh.msh": b"".join(c.to_bytes(4, "little") for c in (count, small, small, count)) + source.randbytes(40),
        "mesh.png": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + 2 * count.to_bytes(4, "big") + b"\x08\x06\0\0\0" + b"\0" * 8,
        "inner.xml": source.choice(HUGE + ('<include file="model.xml"/>', '<include file="inner.xml"/>')).encode(),
    }
    content = made[name]
    return draw.mutated(source, content) if draw.chance(source, 0.5) else content
