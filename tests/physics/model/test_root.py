"""A model reads what it includes anywhere in the repository or package that it came in, and nothing beyond."""

from pathlib import Path

import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.model.root import model_root
from tests.physics.meshes import write_box

BODY = '<body><joint axis="0 1 0"/><geom size=".1"/></body>'


def write(path: Path, text: str = "") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("marks", "root"),
    [
        ([".git/HEAD"], "."),
        ([".git/HEAD", "robots/pyproject.toml"], "robots"),
        (["pyproject.toml", "robots/arm/package.xml"], "robots/arm"),
        (["robots/__init__.py", "robots/arm/__init__.py"], "robots"),
        (["pyproject.toml", "robots/arm/mjcf/__init__.py"], "robots/arm/mjcf"),
        ([], "."),
    ],
)
def test_the_nearest_repository_or_package_is_the_root_else_three_folders_up(
    tmp_path: Path, marks: list[str], root: str
) -> None:
    for mark in marks:
        write(tmp_path / mark)
    model = write(tmp_path / "robots" / "arm" / "mjcf" / "arm.xml")
    assert model_root(model) == (tmp_path / root).resolve()


def test_a_model_does_not_read_all_of_a_home_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path / "me"))
    assert model_root(write(tmp_path / "me" / "robots" / "arm.xml")) == (tmp_path / "me" / "robots").resolve()
    assert model_root(write(tmp_path / "me" / "a" / "b" / "arm.xml")) == (tmp_path / "me" / "a").resolve()


@pytest.fixture
def collection(tmp_path: Path) -> Path:
    """A model whose scene and meshes stand beside its folder, and what it may not read above the root."""
    write_box(tmp_path / "collection" / "stls" / "link.stl")
    write(tmp_path / "collection" / "scene" / "floor.xml", f"<mujoco><worldbody>{BODY}</worldbody></mujoco>")
    main = '<mujoco><compiler meshdir="../stls"/><include file="../scene/floor.xml"/><asset><mesh file="link.stl"/>'
    main += '</asset><worldbody><geom type="mesh" mesh="link"/></worldbody></mujoco>'
    return write(tmp_path / "collection" / "arm" / "arm.xml", main)


def test_scenes_and_meshes_beside_the_models_folder_are_found(collection: Path) -> None:
    one = Robot.from_xml(collection)
    assert one.model.nmesh == 1 and one.model.njnt == 1
    assert Robot.from_xml(collection, collection.parents[1]).model.nmesh == 1


def test_a_narrower_root_refuses_them_and_is_named(collection: Path) -> None:
    with pytest.raises(InputError, match=r"leads out of the model's root; .*collection/arm; .*--root DIR"):
        Robot.from_xml(collection, collection.parent)
    write(collection.parent / "package.xml", "<package/>")
    with pytest.raises(InputError, match=r"leads out of the model's root"):
        Robot.from_xml(collection)
    assert Robot.from_xml(collection, collection.parents[1]).model.nmesh == 1


@pytest.mark.parametrize("root", ["none", "collection/scene"])
def test_a_root_is_a_folder_above_the_model(tmp_path: Path, collection: Path, root: str) -> None:
    with pytest.raises(InputError, match=r"--root .*a folder above the model"):
        Robot.from_xml(collection, tmp_path / root)
