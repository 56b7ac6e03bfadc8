"""The independent answer to every component: by its name, what it puts out at a point, or from instant to instant."""

from ..law import Law, Sampled
from . import adaptive, deruiter, gyro_free, observer_pd, operator, sensors, six_dof, trigo, velocity_free

LAWS: dict[str, Law] = {
    **observer_pd.LAWS,
    **adaptive.LAWS,
    **gyro_free.LAWS,
    **deruiter.LAWS,
    **trigo.LAWS,
    **velocity_free.LAWS,
    **six_dof.LAWS,
    **operator.LAWS,
    **sensors.LAWS,
}
SAMPLED: dict[str, Sampled] = {**trigo.SAMPLED, **sensors.SAMPLED}
