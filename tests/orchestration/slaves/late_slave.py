"""y = 2 u, computed in do_step as most slaves do it; fails at `fails_at`."""

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real, String


class LateSlave(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u, self.y, self.fails_at = 0.0, 0.0, 1e9
        self.count, self.odd, self.text = 0, False, "fine"
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("y", causality=Fmi2Causality.output))
        discrete = {"causality": Fmi2Causality.output, "variability": Fmi2Variability.discrete}
        self.register_variable(Integer("count", **discrete))
        self.register_variable(Boolean("odd", **discrete))
        self.register_variable(String("text", **discrete))
        self.register_variable(Real("fails_at", causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))

    def do_step(self, current_time, step_size):
        if current_time >= self.fails_at:
            raise ValueError("out of fuel")
        self.y = 2 * self.u
        self.count += 1
        self.odd = not self.odd
        return True
