"""The mutants are what they should be; trying them is `make mutants`."""

from fmus import catalog

from . import report
from .changes import KINDS, mutants_of
from .explained import reason
from .trial import own_headers


def test_each_kind_of_change_is_one_slip_of_the_pen() -> None:
    header = catalog.find("RigidBody").header
    made = {kind: [m.after for m in mutants_of(header, kind)] for kind in KINDS}
    assert "H_N = dcm(q_BN) * H_B;" in made["transpose"]
    assert "kinetic_energy = 0.505 * omega_BN_B.dot(H_B);" in made["factor"]
    swapped = "torque_B + torque_disturbance_B - Vec3<T>(H_B).cross(omega_BN_B)"
    assert f"omegaDot_BN_B = J_B.inverse() * ({swapped});" in made["cross product"]
    assert "omegaDot_BN_B = J_B.inverse() * (torque_B - omega_BN_B.cross(H_B));" in made["dropped term"]
    assert "omegaDot_BN_B = J_B.inverse() * (torque_B + torque_disturbance_B + omega_BN_B.cross(H_B));" in made["sign"]
    assert "const Vec3<T> H_B = J_B * omegaDot_BN_B;" in made["other variable"]


def test_declarations_stay_and_ten_places_can_be_changed_in_every_law_but_one() -> None:
    for component in catalog.components():
        made = [m for header in own_headers(component.header) for kind in KINDS for m in mutants_of(header, kind)]
        assert not [m for m in made if m.before.startswith(("v.", "static constexpr", "//"))]
        assert len(made) >= 10 or component.name == "TorqueSwitch"  # a product of two factors


def test_what_survived_has_a_reason() -> None:
    survivors = [s for outcome in report.read().values() for s in outcome["survivors"]]
    assert [s for s in survivors if not reason(s["before"], s["after"])] == []
