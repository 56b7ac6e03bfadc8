"""A result as people meet it: its names, elements and equality, as tables of other libraries, in notebooks."""

import sys
from html.parser import HTMLParser

import numpy as np
import pytest

from adcs import AdcsError, RunFailed, Save, System, run, until


@pytest.fixture(params=["memory", "file"])
def result(chain, request, tmp_path):
    """Of integrator, gain and source; u = 2 * (offset + t) is integrated from (0, 0, 10)."""
    return run(chain(), stop_time=1.0, step=0.1, save=Save(to=None if request.param == "memory" else tmp_path / "r.h5"))


def of(system, **settings):
    return run(system, stop_time=1.0, step=0.1, **settings)


class Cells(HTMLParser):
    """The texts of a page's table cells, row by row, and all tags."""

    def __init__(self, page):
        super().__init__()
        self.rows, self.tags = [], set()
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_data(self, data):
        if self.rows and self.rows[-1]:
            self.rows[-1][-1] += data


def test_names(result):
    assert list(result) == result.names == ["integrator.y", "gain.y", "gain.doubled", "source.y"]
    assert len(result) == 4
    assert "gain.y" in result and "gain.y[3]" in result
    for no in ("gain.z", "gain.y[4]", "gain.y[0]", "gain.y[", "nobody.y", "", "gain.u", 1, None, ["gain.y"]):
        assert no not in result


def test_it_is_like_a_dict(result):
    arrays = dict(result)
    assert list(arrays) == list(result.keys()) == result.names
    assert np.array_equal(arrays["gain.y"], result["gain.y"])
    assert [name for name, values in result.items() if values.shape[0] == len(result.time)] == result.names
    assert np.array_equal(result.get("gain.y[2]"), result["gain.y"][:, 1])
    assert result.get("nobody.y") is None and result.get("nobody.y", 3) == 3


def test_a_result_without_variables_is_one_all_the_same(chain):
    nothing = of(chain(), save=Save([]))
    assert nothing and len(nothing) == 0
    assert nothing == of(chain(), save=Save([]))
    assert repr(nothing) == "<Result of chain: 11 rows, 0 to 1 s; no variables; complete>"
    with pytest.raises(AdcsError, match=r"^there is nothing to plot: no variable was recorded$"):
        nothing.plot()


def test_elements_are_counted_from_1(result):
    np.testing.assert_allclose(result["source.y[2]"], 2.0 + result.time)
    assert np.array_equal(result["source.y[3]"], result["source.y"][:, 2])
    assert result.unit("gain.y[1]") == result.unit("gain.y") == "m/s"
    with pytest.raises(AdcsError, match=r"^source\.y\[4\] does not exist: source\.y has 3 values, counted from 1$"):
        result["source.y[4]"]
    with pytest.raises(AdcsError, match=r"^'gain\.z\[1\]' was not recorded: did you mean gain\.y"):
        result["gain.z[1]"]
    with pytest.raises(AdcsError, match=r"^2 names no variable: give a text as 'integrator\.y'$"):
        result[2]
    with pytest.raises(AdcsError, match=r"^gain\.y\[1\] is an element of an array: select gain\.y$"):
        result.select(["gain.y[1]"])


@pytest.mark.parametrize("to_file", [False, True])
def test_elements_of_matrices_and_of_other_types(mock, tmp_path, to_file, version):
    system = System("typed")
    system.add("typed", mock("typed", version))
    record = [*system.outputs(), "typed.matrix"]
    result = run(system, stop_time=1, step=0.5, save=Save(record, to=tmp_path / "r.h5" if to_file else None))
    for name in result:
        whole = result[name]
        for index in np.ndindex(whole.shape[1:]):
            element = result[f"{name}[{','.join(str(i + 1) for i in index)}]"] if index else result[name]
            assert np.array_equal(element, whole[:, *index]) and element.dtype == whole.dtype
    assert np.array_equal(result["typed.matrix[2, 3]"], result["typed.matrix[2,3]"])


def test_equality(chain, tmp_path):
    result = of(chain())
    assert result == of(chain()) == of(chain(), save=Save(to=tmp_path / "r.h5"))
    assert of(chain(), save=Save(to=tmp_path / "s.h5")) == result
    assert result == result.select(result.names[::-1])
    assert result != result.select(["gain.y"])
    assert result != run(chain(), stop_time=0.9, step=0.1)
    assert result != run(chain(), start_time=1.0, stop_time=2.0, step=0.1)
    assert result != 1 and result != "chain" and result is not None
    other = of(chain())
    other.data[3, 0] = np.nextafter(other.data[3, 0], 100.0)
    assert result != other
    other.data[3, 0] = result.data[3, 0] = np.nan
    assert result == other
    other.data[3, 0], result.data[3, 0] = 0.0, -0.0
    assert result != other


def test_a_result_in_a_line(result):
    assert repr(result) == (
        "<Result of chain: 11 rows, 0 to 1 s; integrator.y, gain.y, gain.doubled, source.y; complete>"
    )


def test_a_result_as_a_table(result):
    page = result._repr_html_()
    cells = Cells(page)
    assert cells.tags == {"div", "p", "b", "table", "tr", "th", "td"}
    assert "color" not in page and "background" not in page  # the notebook's own, light or dark
    assert "<b>chain</b>: 11 rows, 0 to 1 s; complete" in page
    assert cells.rows[0] == ["variable", "unit", "shape", "at 1 s"]
    assert ["gain.y", "m/s", "3", "4 6 8"] in cells.rows


def test_how_a_run_ended_is_said(chain, faulty):
    assert repr(of(chain(), hooks=[until("source.y[1] > 1.45")])).endswith("; complete, source.y[1] > 1.45 at 0.5 s>")
    with pytest.raises(RunFailed) as failed:
        run(faulty("2.0", 1), stop_time=1.0, step=0.1)
    told = "failed, wheel at 0.5 s: doStep returned error: the wheel is stuck"
    assert repr(failed.value.result).endswith(f"; {told}>")
    assert told in failed.value.result._repr_html_()


def test_pandas(result):
    frame = result.to_pandas()
    assert frame.index.name == "time [s]" and np.array_equal(frame.index, result.time)
    assert list(frame.columns[-3:]) == ["source.y[1]", "source.y[2]", "source.y[3]"]
    assert np.array_equal(frame["gain.y[2]"], result["gain.y[2]"])
    assert frame.attrs["units"]["gain.y[2]"] == "m/s"


def test_xarray(result):
    data = result.to_xarray()
    assert list(data) == result.names and data.attrs["system"] == "chain"
    assert data["gain.y"].dims == ("time", "gain.y_dim_1") and data["gain.y"].attrs["units"] == "m/s"
    assert np.array_equal(data["gain.y"].sel({"gain.y_dim_1": 2}), result["gain.y[2]"])
    assert data["time"].attrs["units"] == "s"


def test_types_survive(mock):
    system = System("typed")
    system.add("typed", mock("typed"))
    result = run(system, stop_time=1, step=1)
    data, frame = result.to_xarray(), result.to_pandas()
    for name in result:
        assert data[name].dtype == result[name].dtype
    assert {str(t) for t in frame.dtypes} == {str(result[name].dtype) for name in result}


@pytest.mark.parametrize("package", ["pandas", "xarray"])
def test_what_is_not_installed_is_named(chain, monkeypatch, package):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(AdcsError, match=rf"^{package} is not installed: python -m pip install {package}$"):
        getattr(of(chain()), f"to_{package}")()


def test_plot(result):
    figure = result.plot("gain.y", "source.y[2]")
    first, second = figure.axes
    assert first.get_title(loc="left") == "gain.y" and first.get_ylabel() == "[m/s]"
    assert [entry.get_text() for entry in first.get_legend().get_texts()] == ["y[1]", "y[2]", "y[3]"]
    assert np.array_equal(second.lines[0].get_ydata(), result["source.y[2]"]) and second.get_legend() is None
    assert len(result.plot().axes) == 4
    assert figure._repr_png_().startswith(b"\x89PNG") and figure._repr_png_() == figure._repr_png_()
    with pytest.raises(AdcsError, match=r"'gain\.z' was not recorded"):
        result.plot("gain.z")
