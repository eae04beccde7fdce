"""Tables as text and as HTML."""

from estexp_jax.report.tables import TextTable, html_table


def test_cells_are_escaped_and_floats_shortened():
    assert html_table(["<a>", "b"], [["x & y", 0.123456], [None, 7]]) == (
        '<div style="overflow-x:auto">'
        "<table><tr><th>&lt;a&gt;</th><th>b</th></tr><tr><td>x &amp; y</td><td>0.123</td></tr>"
        "<tr><td>None</td><td>7</td></tr></table></div>"
    )


def test_text_tables_align_their_columns():
    table = TextTable("title <b>", ("pass", "diagnosis"), [("1", "a <b>"), ("20", "x")])
    assert table.text() == "title <b>\npass  diagnosis\n1     a <b>\n20    x"
    assert (
        table.html().startswith('<p>title &lt;b&gt;</p><div style="overflow-x:auto"><table>')
        and "a &lt;b&gt;" in table.html()
    )
