"""PdTracking for PythonFMU3 (FMI 3.0), with arrays: outputs are computed when they are fetched."""

from pd_law import pd
from pythonfmu3 import Dimension, Float64, Fmi3Causality, Fmi3Slave, Fmi3StepResult, Fmi3Variability

INPUTS = {"q_BN": 4, "omega_BN_B": 3, "q_RN": 4, "omega_RN_R": 3, "omegaDot_RN_R": 3}
OUTPUTS = {"torque_B": 3, "q_BR": 4, "omega_BR_B": 3}


class PdSlave3(Fmi3Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.time = 0.0
        self.values = {name: [1.0, 0.0, 0.0, 0.0][:n] if name[0] == "q" else [0.0] * n for name, n in INPUTS.items()}
        self.values["J_B"] = [10.0, 0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 0.0, 10.0]
        self.k_p, self.k_v = 1.5, 5.0
        independent = Float64("time", causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous)
        self.register_variable(independent)
        for name, n in INPUTS.items():
            self._add(name, Fmi3Causality.input, Fmi3Variability.continuous, n)
        self._add("J_B", Fmi3Causality.parameter, Fmi3Variability.fixed, 3, 3)
        for name in ("k_p", "k_v"):
            self.register_variable(
                Float64(name, causality=Fmi3Causality.parameter, variability=Fmi3Variability.tunable)
            )
        for k, (name, n) in enumerate(OUTPUTS.items()):
            self.register_variable(
                Float64(
                    name,
                    causality=Fmi3Causality.output,
                    variability=Fmi3Variability.continuous,
                    dimensions=[Dimension(start=str(n))],
                    getter=lambda k=k: self._law()[k],
                )
            )

    def _add(self, name, causality, variability, *shape):
        self.register_variable(
            Float64(
                name,
                causality=causality,
                variability=variability,
                dimensions=[Dimension(start=str(n)) for n in shape],
                getter=lambda: self.values[name],
                setter=lambda values: self.values.__setitem__(name, list(values)),
            )
        )

    def _law(self):
        J = self.values["J_B"]
        values = {**self.values, "J_B": [J[:3], J[3:6], J[6:]]}
        return pd(**values, k_p=self.k_p, k_v=self.k_v)

    def do_step(self, current_time, step_size):
        return Fmi3StepResult()
