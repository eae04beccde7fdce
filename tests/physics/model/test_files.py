"""Models with files: found under the model's root, refused elsewhere, and taken along."""

import os
import struct
from pathlib import Path

import mujoco
import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.choice import choose_engine
from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.physics.engines.mjx.model import mjx_model
from estexp_jax.physics.model.portable import portable
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.model.xml_text import xml_elements
from tests.physics.meshes import mjcf, urdf, write_box

BODY = '<body><joint axis="0 1 0"/><geom size=".1"/></body>'
PNG = b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sII", 13, b"IHDR", 60_000, 60_000) + bytes(20)


def _write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("mesh", "model", "package"),
    [
        ("link.stl", "link.urdf", False),
        ("meshes/link.stl", "arm.urdf", False),
        ("package://arm_description/meshes/link.stl", "arm.urdf", False),
        ("package://arm_description/meshes/link.stl", "urdf/arm.urdf", True),
        ("../meshes/link.stl", "urdf/arm.urdf", True),
        ("model://arm/meshes/link.stl", "arm.xml", False),
    ],
)
def test_a_urdf_finds_its_meshes(tmp_path: Path, mesh: str, model: str, package: bool) -> None:
    write_box(tmp_path / ("link.stl" if "/" not in mesh else "meshes/link.stl"))
    if package:
        _write(tmp_path / "package.xml", "<package/>")
    arm = Robot.from_xml(_write(tmp_path / model, urdf(mesh)))
    assert arm.model.nmesh == 1 and arm.names("joint") == ("shoulder", "elbow")
    np.testing.assert_allclose(
        arm.model.mesh_vert[: arm.model.mesh_vertnum[0]].max(axis=0), [0.02, 0.02, 0.1], atol=0.01
    )


def test_a_urdf_has_no_motors_and_what_to_do_is_said(tmp_path: Path) -> None:
    write_box(tmp_path / "link.stl")
    arm = Robot.from_xml(_write(tmp_path / "arm.urdf", urdf("link.stl")))
    with pytest.raises(InputError, match=r"no jointpos sensor; `estexp check .*arm\.urdf --init` writes an MJCF"):
        interface_of(arm)


def test_included_and_attached_models_come_with_their_files(tmp_path: Path) -> None:
    write_box(tmp_path / "meshes" / "link.stl")
    write_box(tmp_path / "hand" / "shapes" / "link.stl", half=(0.03, 0.03, 0.03))
    _write(tmp_path / "parts" / "a.xml", '<mujoco><include file="b.xml"/></mujoco>')
    _write(tmp_path / "parts" / "b.xml", f"<mujoco><worldbody>{BODY}</worldbody></mujoco>")
    hand = (
        '<mujoco><compiler meshdir="shapes"/><asset><mesh name="m" file="link.stl"/></asset><worldbody><body name="h">'
    )
    _write(tmp_path / "hand" / "hand.xml", hand + '<geom type="mesh" mesh="m"/></body></worldbody></mujoco>')
    main = (
        '<mujoco><!-- a -- b --><compiler meshdir="meshes"/><include file="parts/a.xml"/><asset><mesh file="link.stl"/>'
    )
    main += '<model name="hand" file="hand/hand.xml"/></asset><worldbody><geom type="mesh" mesh="link"/>'
    path = _write(tmp_path / "main.xml", main + '<attach model="hand" body="h" prefix="x_"/></worldbody></mujoco>')
    with pytest.raises(InputError, match="'link.stl' may be any of 2 files"):
        _write(tmp_path / "hand" / "meshes" / "link.stl", "other")
        Robot.from_xml(path)
    (tmp_path / "hand" / "meshes" / "link.stl").unlink()
    whole = Robot.from_xml(path)
    assert whole.model.njnt == 1
    assert [Path(mesh.file).parent.name for mesh in whole.spec.meshes] == ["meshes", "shapes"]


def test_a_model_takes_its_files_along(tmp_path: Path) -> None:
    write_box(tmp_path / "one" / "meshes" / "link.stl")
    text = mjcf().replace("<asset>", '<asset><mesh name="other" file="more/link.stl"/>')
    write_box(tmp_path / "one" / "meshes" / "more" / "link.stl", half=(0.1, 0.1, 0.1))
    arm = Robot.from_xml(_write(tmp_path / "one" / "arm & co.xml", text))
    moved, files = portable(arm.spec)
    assert set(files) == {"link.stl", "link_2.stl"} and str(tmp_path) not in moved
    _write(tmp_path / "two" / "arm.xml", moved)
    for name, source in files.items():
        (tmp_path / "two" / "assets").mkdir(exist_ok=True)
        (tmp_path / "two" / "assets" / name).write_bytes(source.read_bytes())
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "two" / "arm.xml"))
    np.testing.assert_allclose(np.sort(model.mesh_vert, axis=0), np.sort(arm.model.mesh_vert, axis=0), atol=1e-6)


@pytest.mark.parametrize(("touching", "engine"), [(False, "lanes"), (True, "mjx")])
def test_meshes_that_only_show_leave_lanes_alone(tmp_path: Path, touching: bool, engine: str) -> None:
    write_box(tmp_path / "meshes" / "link.stl")
    arm = Robot.from_xml(_write(tmp_path / "arm.xml", mjcf(touching=touching)))
    on_mjx = mjx_model(arm, catalogue(["viscous_friction"]))
    choice = choose_engine("auto", on_mjx)
    assert choice.engine == engine
    if touching:
        assert "contact between geoms" in choice.reason
        with pytest.raises(InputError, match="use --engine mjx"):
            choose_engine("lanes", on_mjx)


OUT = {
    "include": '<include file="{}"/>',
    "attached model": '<asset><model name="a" file="{}"/></asset>',
    "mesh": '<asset><mesh name="m" file="{}"/></asset>',
    "texture": '<asset><texture name="t" type="2d" file="{}"/></asset>',
    "side of a cube": '<asset><texture name="t" type="cube" fileleft="{}"/></asset>',
    "height field": '<asset><hfield name="h" size="1 1 1 1" file="{}"/></asset>',
    "skin": '<asset><skin name="s" file="{}"/></asset>',
    "grid": '<worldbody><flexcomp name="f" type="mesh" file="{}"/></worldbody>',
}


@pytest.mark.parametrize("kind", OUT)
@pytest.mark.parametrize(
    "way", ["../secret.xml", "{}/secret.xml", "linked.xml", "folder/secret.xml", "a/../../secret.xml"]
)
def test_nothing_outside_is_opened(tmp_path: Path, kind: str, way: str) -> None:
    """Up, absolute, by a link to a file, by a link to a folder, up through a folder that is not there."""
    _write(tmp_path / "secret.xml", f"<mujoco><worldbody>{BODY}</worldbody></mujoco>")
    _write(tmp_path / "own" / "package.xml", "<package/>")
    (tmp_path / "own" / "linked.xml").symlink_to(tmp_path / "secret.xml")
    (tmp_path / "own" / "folder").symlink_to(tmp_path)
    text = f"<mujoco>{OUT[kind].format(way.format(tmp_path))}<worldbody>{BODY}</worldbody></mujoco>"
    # A long path ends in three points.
    with pytest.raises(InputError, match=r"(secret.xml'|linked.xml'|\.\.\.) leads out"):
        Robot.from_xml(_write(tmp_path / "own" / "model.xml", text))


@pytest.mark.parametrize("folder", ['meshdir=".."', 'meshdir="/etc"', 'assetdir="../.."', 'meshdir="up"'])
def test_folders_of_files_stay_inside(tmp_path: Path, folder: str) -> None:
    write_box(tmp_path / "link.stl")
    _write(tmp_path / "own" / "pyproject.toml", "")
    (tmp_path / "own" / "up").symlink_to("..")
    text = f'<mujoco><compiler {folder}/><asset><mesh file="link.stl"/></asset><worldbody>{BODY}</worldbody></mujoco>'
    with pytest.raises(InputError, match="'link.stl' leads out of the model's root"):
        Robot.from_xml(_write(tmp_path / "own" / "model.xml", text))


@pytest.mark.parametrize(
    "mesh", ["package://../link.stl", "package://x/../../link.stl", "/dev/zero", "file:///dev/zero"]
)
def test_ways_out_of_a_urdf(tmp_path: Path, mesh: str) -> None:
    write_box(tmp_path / "link.stl")
    _write(tmp_path / "own" / "package.xml", "<package/>")
    with pytest.raises(InputError, match="leads out of|there is no file"):
        Robot.from_xml(_write(tmp_path / "own" / "arm.urdf", urdf(mesh)))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("<mujoco><worldbody><replicate count='1000000000'>" + BODY + "</replicate></worldbody></mujoco>", "elements"),
        (
            "<mujoco><worldbody>" + "<replicate count='200'>" * 4 + BODY + "</replicate>" * 4 + "</worldbody></mujoco>",
            "ele",
        ),
        ("<mujoco><worldbody>" + "<geom size='1'/>" * 30_000 + "</worldbody></mujoco>", "more than 20,000 elements"),
        (
            "<mujoco><worldbody><flexcomp count='100000 1000 1000'/></worldbody></mujoco>",
            "<flexcomp>: the model has or",
        ),
        (
            "<mujoco><asset><hfield name='h' nrow='100000' ncol='100000'/></asset></mujoco>",
            "<hfield>: claims more than",
        ),
        (
            "<mujoco><asset><texture builtin='flat' width='100000' height='600000'/></asset></mujoco>",
            "<texture>: claims",
        ),
        ("<mujoco><size nkey='1000000000'/></mujoco>", "nkey is '1000000000'; at most 10,000"),
        ("<mujoco><size nstack='100000000'/></mujoco>", "nstack is '100000000'; at most 67,108,864"),
        ("<mujoco><size nuser_body='" + "9" * 5000 + "'/></mujoco>", "nuser_body is '999.*at most"),
        ("<mujoco>\n\n<worldbody></mujoco>", "line 3: is not well-formed XML: mismatched tag"),
        ("<mujoco>\n<!-- no end", "line 2: is not well-formed XML; close every <"),
        ("<!DOCTYPE m [<!ENTITY a 'b'>]><mujoco model='&a;'/>", "is not well-formed XML"),
        ("<mujoco><geom name='<!--'/><include file='/etc/passwd'/><geom name='-->'/></mujoco>", "is not well-formed"),
        ("", "is not well-formed XML: no element found"),
        ("<body" * 100_000, "is not well-formed XML"),
        ("<body>" * 19_000 + "</body>" * 19_000, "does not compile"),
    ],
)
def test_texts_that_claim_too_much(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(InputError, match=told):
        Robot.from_xml(_write(tmp_path / "model.xml", text))


def test_room_that_older_models_ask_for(tmp_path: Path) -> None:
    body = "<worldbody><body><joint/><geom size='.1' mass='1'/></body></worldbody>"
    text = f"<mujoco><size nstack='300000' njmax='5000' nconmax='20000'/>{body}</mujoco>"
    assert Robot.from_xml(_write(tmp_path / "model.xml", text)).model.nv == 1


def test_files_that_are_too_large_or_none(tmp_path: Path) -> None:
    model = _write(tmp_path / "model.xml", OUT["texture"].format("t.png").join(("<mujoco>", "</mujoco>")))
    (tmp_path / "t.png").write_bytes(PNG)
    with pytest.raises(InputError, match=r"texture 't': 't\.png' claims 60,000 x 60,000 pixels"):
        Robot.from_xml(model)
    with (tmp_path / "t.png").open("wb") as stream:
        stream.truncate(10**12)  # no byte of it is on the disk
    with pytest.raises(InputError, match="is 1,000,000,000,000 bytes long"):
        Robot.from_xml(model)
    (tmp_path / "t.png").unlink()
    os.mkfifo(tmp_path / "t.png")
    with pytest.raises(InputError, match=r"there is no file 't\.png' under the model's root"):
        Robot.from_xml(model)
    with model.open("wb") as stream:
        stream.truncate(10**12)
    with pytest.raises(InputError, match="bytes long"):
        Robot.from_xml(model)
    (tmp_path / "broken.stl").write_bytes(b"\xff" * 200)
    with pytest.raises(InputError, match="does not compile"):
        Robot.from_xml(_write(model, f"<mujoco>{OUT['mesh'].format('broken.stl')}</mujoco>"))


def test_collada_is_named(tmp_path: Path) -> None:
    write_box(tmp_path / "link.dae")
    with pytest.raises(InputError, match="Collada file; convert it to OBJ, STL or MSH"):
        Robot.from_xml(_write(tmp_path / "arm.urdf", urdf("link.dae")))


def test_rings_of_includes_end(tmp_path: Path) -> None:
    _write(tmp_path / "a.xml", '<mujoco><include file="b.xml"/></mujoco>')
    with pytest.raises(InputError, match="does not compile"):
        Robot.from_xml(_write(tmp_path / "b.xml", '<mujoco><include file="a.xml"/></mujoco>'))


@pytest.mark.parametrize("inside", ['<asset><model name="y" file="a.xml"/></asset>', '<include file="a.xml"/>'])
def test_models_that_attach_themselves_are_refused(tmp_path: Path, inside: str) -> None:
    """MuJoCo follows such a ring until its stack ends, and the process with it."""
    own = '<mujoco><asset><model name="x" file="{}"/></asset></mujoco>'
    with pytest.raises(InputError, match="attaches own.xml, which it is a part of"):
        Robot.from_xml(_write(tmp_path / "own.xml", own.format("own.xml")))
    _write(tmp_path / "b.xml", f"<mujoco>{inside}</mujoco>")
    with pytest.raises(InputError, match="attaches a.xml, which it is a part of"):
        Robot.from_xml(_write(tmp_path / "a.xml", own.format("b.xml")))


def test_comments_and_data_are_read_as_they_are() -> None:
    text = "<a><!-- <b/> -- -->\n<c d='>'/><![CDATA[ <e/> ]]><!DOCTYPE x></a>".replace("<!DOCTYPE x>", "")
    assert [(e.tag, dict(e.attributes)) for e in xml_elements(text, "x")] == [("a", {}), ("c", {"d": ">"})]
