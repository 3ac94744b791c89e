"""Figures as elements of a page."""

from matplotlib.figure import Figure

from multilayer.report.style import png
from multilayer.report.svg import inline_svg


def test_a_figure_is_given_back_as_it_was():
    figure = Figure(figsize=(3, 2), dpi=150)
    axis = figure.subplots()
    axis.plot([0, 1], [1, 0])
    axis.inset_axes((0.5, 0.5, 0.4, 0.4)).plot([0, 1], [0, 1])
    before = png(figure)
    element = inline_svg(figure, "f", "two lines")
    assert png(figure) == before
    assert "fill: var(--paper" not in element  # the page shows through
    assert element.count("<path") > 2
