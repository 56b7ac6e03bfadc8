"""What the model structure says of parameters; of inputs and states see `tests/laws/test_every_law.py`."""

from tests.one_fmu import unpacked


def test_parameters_are_listed_where_the_standard_counts_them_among_the_knowns() -> None:
    """During a run FMI 3.0 does, and what is not listed has no influence by its text; FMI 2.0 does not."""

    def knowns(version: int) -> dict[str, set[str]]:
        outputs = unpacked("PdTracking", version)[1].outputs
        return {u.variable.name: {d.name for d in u.dependencies} for u in outputs}

    assert {"k_p", "k_v", "J_B", "short_way"} <= knowns(3)["torque_B"]
    assert knowns(3)["omega_BR_B"] & {"k_p", "k_v", "J_B"} == set()
    assert not {name for names in knowns(2).values() for name in names if name.startswith(("k_", "J_", "short"))}
