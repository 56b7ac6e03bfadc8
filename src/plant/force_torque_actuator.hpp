/// # Force and torque actuator
///
/// Passes the commanded force and torque on to the body, each axis limited if a limit is given,
///
/// $$F_i = \max(-F_{max}, \min(F_{max}, F_{c,i})), \qquad \tau_i = \max(-\tau_{max}, \min(\tau_{max}, \tau_{c,i}))$$
///
/// and adds up what they cost, $\int |F|\,dt$ and $\int |\tau|\,dt$: the first, divided by the mass, is the velocity
/// increment. A limit of 0 means none.
#pragma once

#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct ForceTorqueActuator {
    static constexpr auto summary = "Force and torque with optional limits, and what they add up to";
    static constexpr auto reference = "Made for this project, from no publication";

    Vec3<T> force_command_B{0.0, 0.0, 0.0}, torque_command_B{0.0, 0.0, 0.0};
    T max_force = 0.0, max_torque = 0.0;
    T impulse = 0.0, impulseDot = 0.0, angular_impulse = 0.0, angular_impulseDot = 0.0;
    Vec3<T> force_B{0.0, 0.0, 0.0}, torque_B{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("force_command_B", force_command_B, unit::N, "commanded force, in B");
        v.input("torque_command_B", torque_command_B, unit::N_m, "commanded torque, in B");
        v.parameter("max_force", max_force, unit::N, "largest force on each axis; 0: no limit").at_least(0);
        v.parameter("max_torque", max_torque, unit::N_m, "largest torque on each axis; 0: no limit").at_least(0);
        v.state("impulse", impulse, impulseDot, unit::N_s, "integral of the size of the force");
        v.state("angular_impulse", angular_impulse, angular_impulseDot, unit::N_m_s,
                "integral of the size of the torque");
        v.output("force_B", force_B, unit::N, "force on the body, in B");
        v.output("torque_B", torque_B, unit::N_m, "torque on the body, in B");
    }

    void outputs() {
        force_B = limited(force_command_B, max_force);
        torque_B = limited(torque_command_B, max_torque);
    }

    void derivatives() {
        impulseDot = size(force_B);
        angular_impulseDot = size(torque_B);
    }

private:
    static Vec3<T> limited(const Vec3<T>& command, const T& limit) {
        Vec3<T> x = command;
        for (int i = 0; i < 3 && limit > 0.0; ++i) {
            if (x[i] > limit) x[i] = limit;
            if (x[i] < -limit) x[i] = -limit;
        }
        return x;
    }
    static T size(const Vec3<T>& x) {
        const T square = x.dot(x);
        return square > 0.0 ? sqrt(square) : square;  // whose derivative at 0 does not exist
    }
};

}  // namespace adcs
