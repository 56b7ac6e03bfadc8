"""`adcs.bridge`: the bridge as a hook of a run, made with the options of the command line."""

import pytest

import adcs


def test_it_takes_part_in_a_run():
    system = adcs.systems()["observer-pd"].build()
    with adcs.bridge(system, to=("udpout:127.0.0.1:24550",), speed=50) as bridge:
        result = adcs.run(system, stop_time="1s", hooks=[adcs.pace(50), bridge])
    assert len(result.time) == 101
    (endpoint,) = result.manifest["mavlink"]["endpoints"]
    assert endpoint["endpoint"] == "udpout:127.0.0.1:24550"
    assert endpoint["sent"] > 20
    assert result.manifest["watchers"] == ["Bridge"]
    assert result.manifest["chosen"] == {"method": "co-simulation", "because": "it keeps to the clock"}
    assert adcs.run("observer-pd", stop_time="1s", method=adcs.CoSimulation()) == result


def test_what_is_allowed_rewires_the_system():
    system = adcs.systems()["observer-pd"].build()
    before = list(system.components)
    adcs.bridge(system, allow="attitude")
    assert len(system.components) > len(before)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"alow": "param"}, "bridge has no option 'alow': did you mean allow"),
        ({"allow": "fly"}, "--allow fly: expected some of"),
        ({"speed": "fast"}, "speed = 'fast': expected a number"),
        ({"step": "soon"}, "step: 'soon' is not a time, write 120s"),
    ],
)
def test_mistakes_are_one_line(options, said):
    with pytest.raises(adcs.AdcsError) as error:
        adcs.bridge(adcs.systems()["observer-pd"].build(), **options)
    assert str(error.value).startswith(said) and "\n" not in str(error.value)
