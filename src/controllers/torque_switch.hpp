/// # Torque switch
///
/// Stands between a control law and what takes its torque, and opens or closes the loop:
///
/// $$\tau_a = e\,\tau, \qquad e \in \{0, 1\}$$
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct TorqueSwitch {
    static constexpr auto summary = "Passes the control torque on, or none";
    static constexpr auto reference = "Made for this project, from no publication";

    Vec3<T> torque_B{0.0, 0.0, 0.0}, torque_applied_B{0.0, 0.0, 0.0};
    bool enabled = true;

    template <class V>
    void declare(V& v) {
        v.input("torque_B", torque_B, unit::N_m, "torque that the law asks for, in B");
        v.parameter("enabled", enabled, "whether it is passed on");
        v.output("torque_applied_B", torque_applied_B, unit::N_m, "torque that is passed on, in B");
    }

    void outputs() { torque_applied_B = (enabled ? 1.0 : 0.0) * torque_B; }
};

}  // namespace adcs
