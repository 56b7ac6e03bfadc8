/// # Kepler orbit
///
/// Position and velocity of a point O on an elliptic orbit of a spherical Earth, $\ddot r = -\mu\,r/|r|^3$, in closed
/// form. With semi-major axis $a$, eccentricity $e$ and the mean anomaly $M = M_0 + \sqrt{\mu/a^3}\,t$, Kepler's equation
///
/// $$E - e \sin E = M$$
///
/// gives the eccentric anomaly $E$, by a fixed number of Newton steps, and with it
///
/// $$r = a(\cos E - e)\,p + a\sqrt{1-e^2}\,\sin E\,w, \qquad
///   \dot r = \frac{\sqrt{\mu a}}{|r|}\left(-\sin E\,p + \sqrt{1-e^2}\,\cos E\,w\right)$$
///
/// where $p$ points to the perigee and $w$ from the centre of the Earth along the motion there. As long as the run may be,
/// the orbit does not drift. An orbit that meets the Earth is refused.
#pragma once

#include "attitude/gravity.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct KeplerOrbit {
    static constexpr auto summary = "Elliptic orbit around a spherical Earth, in closed form";
    static constexpr auto reference =
        "Montenbruck, Gill, Satellite Orbits: Models, Methods and Applications, 2000, chapter 2";

    T time = 0.0;
    T semi_major_axis = 7.0e6, eccentricity = 0.0, inclination = 0.0;
    T ascending_node = 0.0, argument_of_perigee = 0.0, mean_anomaly = 0.0;
    T mu = earth_mu, earth_radius = earth_equatorial_radius;
    Vec3<T> r_ON_N{7.0e6, 0.0, 0.0}, v_ON_N{0.0, 0.0, 0.0};
    T altitude = 0.0;

    template <class V>
    void declare(V& v) {
        v.time(time);
        v.parameter("semi_major_axis", semi_major_axis, unit::m, "a, half the long axis of the ellipse")
            .fixed()
            .above(0)
            .nominal(1e7);
        v.parameter("eccentricity", eccentricity, unit::one, "e, 0 for a circle").fixed().at_least(0).at_most(0.9);
        v.parameter("inclination", inclination, unit::rad, "angle between the orbit and the equator of N").fixed();
        v.parameter("ascending_node", ascending_node, unit::rad, "angle from the x axis of N to the ascending node")
            .fixed();
        v.parameter("argument_of_perigee", argument_of_perigee, unit::rad, "angle from the ascending node to perigee")
            .fixed();
        v.parameter("mean_anomaly", mean_anomaly, unit::rad, "M_0, mean anomaly at time 0; 0 at perigee").fixed();
        v.parameter("mu", mu, unit::m3_per_s2, "gravitational parameter of the Earth").fixed().above(0).nominal(4e14);
        v.parameter("earth_radius", earth_radius, unit::m, "radius of the Earth").fixed().above(0).nominal(1e7);
        v.output("r_ON_N", r_ON_N, unit::m, "position of O, in N").nominal(1e7);
        v.output("v_ON_N", v_ON_N, unit::m_per_s, "velocity of O, in N").nominal(1e4);
        v.output("altitude", altitude, unit::m, "height of O above the Earth").nominal(1e6);
    }

    void outputs() {
        const T M = mean_anomaly + sqrt(mu / semi_major_axis) / semi_major_axis * time;
        T E = M + eccentricity * sin(M);
        for (int i = 0; i < newton_steps; ++i) {
            const auto [s, c] = sincos(E);
            E -= (E - eccentricity * s - M) / (1.0 - eccentricity * c);
        }

        const auto [s_node, c_node] = sincos(ascending_node);
        const auto [s_perigee, c_perigee] = sincos(argument_of_perigee);
        const auto [s_tilt, c_tilt] = sincos(inclination);
        const Vec3<T> node{c_node, s_node, 0.0}, ahead{-s_node * c_tilt, c_node * c_tilt, s_tilt};
        const Vec3<T> p = c_perigee * node + s_perigee * ahead, w = c_perigee * ahead - s_perigee * node;

        const auto [s, c] = sincos(E);
        const T minor = sqrt(1.0 - eccentricity * eccentricity);
        r_ON_N = semi_major_axis * ((c - eccentricity) * p + minor * s * w);
        v_ON_N = sqrt(mu / semi_major_axis) / (1.0 - eccentricity * c) * (minor * c * w - s * p);
        altitude = height_above(r_ON_N, earth_radius);
    }

    void validate(Words& refuse) const {
        const T perigee = semi_major_axis * (1.0 - eccentricity);
        if (!(perigee > earth_radius))
            refuse(
                "the orbit meets the Earth: semi_major_axis (1 - eccentricity), the distance of the perigee, must "
                "exceed earth_radius, and is %g m",
                perigee);
    }

private:
    // From M + e sin M Newton's method has converged to the last bits after 6 steps for every M if e <= 0.9.
    static constexpr int newton_steps = 7;
};

}  // namespace adcs
