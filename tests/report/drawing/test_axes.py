"""Parts of axes that several figures share."""

from matplotlib.figure import Figure

from estexp_jax.report.drawing.axes import draw_noise_floor, label_rows, log_axis, short


def test_long_names_are_cut_in_the_middle_line_by_line():
    assert short("short") == "short"
    cut, other = short(f"{'a' * 40}{'b' * 40}\nknee", 11).split("\n")
    assert (cut, other) == ("aaaaa…bbbbb", "knee")


def test_rows_are_labelled_and_one_is_bold():
    axes = Figure().subplots()
    label_rows(axes, range(3), ["a", "$x", "c"], bold=[1])
    labels = axes.get_yticklabels()
    assert [label.get_text() for label in labels] == ["a", "$x", "c"]
    assert [label.get_fontweight() for label in labels] == ["normal", "bold", "normal"]


def test_a_logarithmic_axis_leaves_room_for_numbers():
    axes = Figure().subplots()
    axes.plot([0.1, 10.0], [0, 1])
    log_axis(axes, [0.1, 10.0], " %")
    assert axes.get_xscale() == "log" and axes.get_xlim()[1] > 15.0
    assert axes.xaxis.get_major_formatter()(1.0, 0) == "1 %"


def test_a_noise_floor_is_drawn_where_there_is_noise():
    axes = Figure().subplots()
    draw_noise_floor(axes, 0.0, [1.0])
    assert not axes.get_lines() and not axes.texts
    draw_noise_floor(axes, 0.5, [1.0, 2.0])
    draw_noise_floor(axes, 5.0, [1.0, 2.0])
    assert [text.get_horizontalalignment() for text in axes.texts] == ["left", "right"]
