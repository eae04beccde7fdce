"""Robots with meshes, made of nothing."""

import struct
from pathlib import Path

import numpy as np

FACES = "013 032 467 475 045 051 237 276 026 064 157 173"


def write_box(path: Path, half=(0.02, 0.02, 0.1), centre=(0.0, 0.0, -0.1)) -> Path:
    """A box as a binary STL."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half + centre
    faces = [[int(digit) for digit in face] for face in FACES.split()]
    triangles = b"".join(struct.pack("<12fH", 0, 0, 0, *corners[face].ravel(), 0) for face in faces)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(bytes(80) + struct.pack("<I", len(faces)) + triangles)
    return path


def urdf(mesh: str) -> str:
    """A shoulder and an elbow, each with a mesh that is seen and touched."""
    shape = f'<geometry><mesh filename="{mesh}"/></geometry>'
    link = f"""
  <link name="{{}}"><inertial><origin xyz="0 0 -0.1"/><mass value="1"/>
    <inertia ixx="0.004" iyy="0.004" izz="0.0005" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual>{shape}</visual><collision>{shape}</collision></link>"""
    joint = """
  <joint name="{}" type="revolute"><parent link="{}"/><child link="{}"/><origin xyz="0 0 {}"/><axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="1.5" effort="10" velocity="3"/><dynamics damping="0.1" friction="0"/></joint>"""
    joints = joint.format("shoulder", "base", "upper", 0) + joint.format("elbow", "upper", "lower", -0.2)
    return f'<robot name="arm"><link name="base"/>{link.format("upper")}{link.format("lower")}{joints}\n</robot>\n'


def mjcf(mesh: str = "link.stl", touching: bool = False) -> str:
    """An arm of three parts on servos, drawn as meshes that touch nothing or, above the second part, each other."""
    flags = "" if touching else 'contype="0" conaffinity="0"'
    part = f'<joint name="{{0}}" axis="0 1 0" damping="0.1"/><geom type="mesh" mesh="link" mass="0.5" {flags}/>'
    return f"""
<mujoco model="arm">
  <compiler meshdir="meshes"/>
  <asset><mesh name="link" file="{mesh}"/></asset>
  <worldbody>
    <body>{part.format("a")}
      <body pos="0 0 -.2">{part.format("b")}
        <body pos="0 0 -.2">{part.format("c")}</body></body></body>
  </worldbody>
  <actuator><position joint="a" kp="20"/><position joint="b" kp="20"/><position joint="c" kp="20"/></actuator>
  <sensor><jointpos joint="a"/><jointpos joint="b"/><jointpos joint="c"/></sensor>
</mujoco>
"""
