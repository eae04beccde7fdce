"""Figures for notebooks."""

from matplotlib.figure import Figure

from estexp_jax.report.drawing.picture import Picture


def test_a_picture_shows_itself_as_png_and_is_saved_by_extension(tmp_path):
    picture = Picture(Figure(figsize=(1, 1)))
    assert repr(picture) == "Picture(1 x 1 inches); .save('NAME.png'), .figure"
    assert picture._repr_png_().startswith(b"\x89PNG")
    picture.save(str(tmp_path / "a.svg"))
    assert "<svg" in (tmp_path / "a.svg").read_text()
