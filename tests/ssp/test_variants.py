"""One of several system structures of a file, chosen as SSP itself writes it: `theirs.ssp#Variant.ssd`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from packages import bindings, component, elements, parameters, ssd

from adcs import AdcsError, read_ssp
from adcs.catalogue import find_system
from adcs.cli.app import app
from orchestration.from_file import from_anywhere
from tests.invoking import invoke


def variant(k, stop):
    values = bindings(parameters({"k": f'Real value="{k}"'}))
    return ssd(elements(component("b", "", values)), more=f'<ssd:DefaultExperiment stopTime="{stop}"/>')


@pytest.fixture
def theirs(package):
    """A file with a default and two variants, which lies in the current folder of nobody."""
    return package(
        variant(1, 1),
        None,
        {"Large.ssd": variant(2, 2), "Small Scale.ssd": variant(3, 3), "resources/x.ssd": variant(4, 4)},
    )


CHOICES = {
    "": 1.0,
    "#": 1.0,
    "#SystemStructure.ssd": 1.0,
    "#Large.ssd": 2.0,
    "#Small Scale.ssd": 3.0,
}


@pytest.mark.parametrize("choice", CHOICES)
def test_in_the_name(choice, theirs):
    """Each has its own parameters and stop time."""
    file = read_ssp(f"{theirs}{choice}")
    assert file.system.components["b"].start["k"] == (CHOICES[choice],)
    assert file.stop_time == CHOICES[choice]
    assert file.structure == choice.removeprefix("#") or file.structure == "SystemStructure.ssd"
    assert file.structures == ("SystemStructure.ssd", "Large.ssd", "Small Scale.ssd")
    assert find_system(f"{theirs}{choice}").stop_time == CHOICES[choice]


def test_from_python(theirs):
    assert read_ssp(theirs, structure="Large.ssd").stop_time == 2.0
    assert read_ssp(f"{theirs}#Large.ssd", structure="Large.ssd").stop_time == 2.0
    with pytest.raises(
        AdcsError, match=r"^test\.ssp#Large\.ssd: structure='SystemStructure\.ssd' is another one: leave"
    ):
        read_ssp(f"{theirs}#Large.ssd", structure="SystemStructure.ssd")


@pytest.mark.parametrize("name", ["Lrage.ssd", "Large", "large.ssd", "x.ssd"])
def test_one_that_is_not_there(name, theirs):
    with pytest.raises(AdcsError) as error:
        read_ssp(f"{theirs}#{name}")
    assert str(error.value) == (
        f"test.ssp: it has no system structure {name!r}: choose one of SystemStructure.ssd, Large.ssd, "
        "Small Scale.ssd, resources/x.ssd"
    )


def test_results_of_variants_have_folders_of_their_own(theirs):
    assert find_system(str(theirs)).name == "test"
    assert find_system(f"{theirs}#Large.ssd").name == "test-Large"


def test_a_file_whose_name_has_the_mark(theirs):
    for name in ("a#b.ssp", "a.ssp#b.ssp"):
        renamed = theirs.rename(theirs.with_name(name))
        assert read_ssp(renamed).stop_time == 1.0
        assert read_ssp(f"{renamed}#Large.ssd").stop_time == 2.0
        theirs = renamed


def test_a_structure_outside_of_any_file(tmp_path):
    (tmp_path / "x.ssd").write_text(variant(1, 1))
    for read in (read_ssp, find_system):
        with pytest.raises(
            AdcsError, match=r"x\.ssd is a system structure by itself: pack it as SystemStructure\.ssd in"
        ):
            read(str(tmp_path / "x.ssd"))


def test_names_are_found_from_anywhere(theirs, monkeypatch):
    monkeypatch.chdir(theirs.parent)
    assert from_anywhere("observer-pd") == "observer-pd"
    assert from_anywhere("a.fmu") == str(Path("a.fmu").absolute())
    assert from_anywhere("test.ssp") == str(theirs)
    assert from_anywhere("test.ssp#Large.ssd") == f"{theirs}#Large.ssd"


class TestCommands:
    def call(self, *arguments):
        result = invoke(app, list(map(str, arguments)))
        if result.exception and not isinstance(result.exception, SystemExit):
            raise result.exception
        return result.stdout

    def test_info(self, theirs):
        told = json.loads(self.call("info", f"{theirs}#Large.ssd", "--json"))
        assert (told["structure"], told["stop_time"]) == ("Large.ssd", 2.0)
        assert told["structures"] == ["SystemStructure.ssd", "Large.ssd", "Small Scale.ssd"]
        line = "of Large.ssd; there is also SystemStructure.ssd, Small Scale.ssd, which FILE.ssp#NAME.ssd chooses"
        assert line in " ".join(self.call("info", f"{theirs}#Large.ssd").split())

    def test_export(self, theirs, tmp_path):
        self.call("export", f"{theirs}#Large.ssd", tmp_path / "large.ssp")
        file = read_ssp(tmp_path / "large.ssp")
        assert (file.system.components["b"].start["k"], file.stop_time) == ((2.0,), 2.0)
        assert file.structures == ("SystemStructure.ssd",)


def test_a_variant_is_run(package, foreign, tmp_path):
    """With its parameters, not with those of the default."""

    def with_offset(value):
        row = f'<ssv:Float64 value="{value} {value} {value}"/><ssc:Dimension size="3"/>'
        return ssd(elements(component("c", "", bindings(parameters({"u": row}, version="2.0")))), version="2.0")

    path = package(with_offset(1), {"resources/c.fmu": foreign("sizes")}, {"Other.ssd": with_offset(5)})
    options = ("--stop", "1", "--step", "1", "--out", tmp_path / "out", "--json", "--in-process", "--no-report")
    ran = invoke(app, list(map(str, ("run", f"{path}#Other.ssd", *options))))
    assert ran.exit_code == 0, ran.output
    numbers = {n["label"]: n["value"] for n in json.loads(ran.stdout)["key_numbers"]}
    assert numbers["c.total"] == 15.0
