"""Mutants that no test can see, or none sees yet, and why: by a part of the changed line, as it was and as it is."""

AS_A_COLUMN = "a row is taken for a column where a vector is asked for"
EQUIVALENT = {
    ("T half = sin(0.5 * half_angle)", "-(sin"): "only its square is used",
    ("tilt_direction = random", "1.01 *"): "a direction, whose length is divided out",
    ("T E = M + eccentricity", ""): "where Newton's method starts; it ends in the same place",
    ("const Vec3<T> end = ", "-(c * v"): "only its length counts",
    (
        "const Vec3<T> end = ",
        "Vec3<T>(rate).cross(v)",
    ): "only its length counts, and the product is perpendicular to the rest",
    ("estimate.squaredNorm() < bound", ""): "decides what is refused, which other tests are about",
    ("!(period > 0.0) ? sigma_BO", "!(attitude_noise"): "without noise both are the same attitude",
    ("position_B.row(i).transpose()", "position_B.row(i), "): AS_A_COLUMN,
    ("velocity_B.row(i).transpose()", "velocity_B.row(i))"): AS_A_COLUMN,
    ("velocity_B.row(i).transpose()", "velocity_B.row(i);"): AS_A_COLUMN,
    ("q_last.dot(q_last) > 0.0", "q_last.dot(q_BN_est)"): "the estimate took its sign from what is remembered",
    ("S(0, 2) * S(2, 0)", "S(2, 0) * S(2, 0)"): "S is symmetric",
}


def reason(before: str, after: str) -> str:
    """Why a mutant survives; empty if nobody knows."""
    return next((why for (was, now), why in EQUIVALENT.items() if was in before and now in after), "")
