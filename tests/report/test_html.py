"""HTML tables for notebooks."""

from estexp_jax.report.html import html_table


def test_cells_are_escaped_and_floats_shortened():
    assert html_table(["<a>", "b"], [["x & y", 0.123456], [None, 7]]) == (
        "<table><tr><th>&lt;a&gt;</th><th>b</th></tr><tr><td>x &amp; y</td><td>0.123</td></tr>"
        "<tr><td>None</td><td>7</td></tr></table>"
    )
