"""PdTracking for PythonFMU (FMI 2.0): outputs are computed when they are fetched, so that they never lag."""

from pd_law import pd
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

INPUTS = {"q_BN": 4, "omega_BN_B": 3, "q_RN": 4, "omega_RN_R": 3, "omegaDot_RN_R": 3}
OUTPUTS = {"torque_B": 3, "q_BR": 4, "omega_BR_B": 3}


class PdSlave(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.values = {name: [1.0, 0.0, 0.0, 0.0][:n] if name[0] == "q" else [0.0] * n for name, n in INPUTS.items()}
        self.J_B = [[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]]
        self.k_p, self.k_v = 1.5, 5.0
        for name, n in INPUTS.items():
            for i in range(n):
                self._add(f"{name}[{i + 1}]", Fmi2Causality.input, self.values[name], i)
        for i in range(3):
            for j in range(3):
                self._add(f"J_B[{i + 1},{j + 1}]", Fmi2Causality.parameter, self.J_B[i], j)
        for name in ("k_p", "k_v"):
            self.register_variable(Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))
        for k, (name, n) in enumerate(OUTPUTS.items()):
            for i in range(n):
                getter = lambda k=k, i=i: pd(**self.values, J_B=self.J_B, k_p=self.k_p, k_v=self.k_v)[k][i]  # noqa: E731
                self.register_variable(Real(f"{name}[{i + 1}]", causality=Fmi2Causality.output, getter=getter))

    def _add(self, name, causality, values, i):
        fixed = Fmi2Variability.fixed if causality == Fmi2Causality.parameter else None
        self.register_variable(
            Real(
                name,
                causality=causality,
                variability=fixed,
                getter=lambda: values[i],
                setter=lambda value: values.__setitem__(i, value),
            )
        )

    def do_step(self, current_time, step_size):
        return True
