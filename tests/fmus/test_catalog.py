import re

import pytest

from adcs import AdcsError
from fmus import catalog
from fmus.code import without_comments


def test_the_five_components_with_their_kinds():
    assert {
        "FixedAxisReference": "guidance",
        "RigidBody": "plant",
        "StarTracker": "sensor",
        "SmoothRateObserver": "observer",
        "PdTracking": "controller",
    }.items() <= {c.name: c.kind for c in catalog.components()}.items()


def test_every_component_says_what_it_is():
    for component in catalog.components():
        assert component.summary, component.name
        assert component.text.startswith("# "), component.name


def test_a_name_that_is_nearly_right_gets_a_hint():
    with pytest.raises(AdcsError, match="no component is called Rigidbody: did you mean RigidBody"):
        catalog.find("Rigidbody")


def test_a_struct_must_have_the_name_of_its_file(tmp_path, monkeypatch):
    monkeypatch.setattr(catalog, "SOURCES", tmp_path)
    (tmp_path / "sensors").mkdir()
    (tmp_path / "sensors" / "sun_sensor.hpp").write_text("struct Sunsensor { declare(v) };")
    with pytest.raises(AdcsError, match=r"sun_sensor.hpp:1: there is no `struct SunSensor`, but Sunsensor"):
        catalog.components()


def test_headers_that_declare_nothing_are_shared_between_components(tmp_path, monkeypatch):
    monkeypatch.setattr(catalog, "SOURCES", tmp_path)
    folder = tmp_path / "sensors"
    folder.mkdir()
    (folder / "sun_sensor.hpp").write_text(
        '/// # Sun\n///\n///   $x$\n\nstruct SunSensor { summary = "sees"; declare(v) };'
    )
    (folder / "noise.hpp").write_text("struct Noise { int shared; };")

    (found,) = catalog.components()

    assert (found.name, found.kind, found.summary) == ("SunSensor", "sensor", "sees")
    assert found.include == "sensors/sun_sensor.hpp"
    assert found.text == "# Sun\n\n  $x$\n"


def test_each_component_is_found_by_its_name():
    assert [catalog.find(c.name) for c in catalog.components()] == catalog.components()


def test_a_name_that_is_no_file_name_is_refused_as_any_other():
    for name in ("", "../plant/RigidBody", "A\0B", "rigid_body", "x" * 5000):
        with pytest.raises(AdcsError, match="no component is called"):
            catalog.find(name)


def test_every_component_says_where_it_is_from():
    for component in catalog.components():
        if "auto reference =" not in component.header.read_text():
            continue  # that of the law it is a form of
        reference = without_comments(component.header.read_text()).partition("auto reference =")[2].partition(";")[0]
        assert re.search(r"\b(19|20)\d\d\b|dissertation|equations|Eqs?\.|no publication", reference), component.name
