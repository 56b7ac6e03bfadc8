// The closed loop as one would write it by hand around the same two components: no FMI, no checks, nothing recorded.
#include "controllers/pd_tracking.hpp"
#include "plant/rigid_body.hpp"

#ifdef _WIN32
#define ADCS_API extern "C" __declspec(dllexport)
#else
#define ADCS_API extern "C" __attribute__((visibility("default")))
#endif

namespace {

using namespace adcs;
using State = Eigen::Matrix<double, 7, 1>;

}  // namespace

/// `state` is [q_BN, omega_BN_B], at the start and then at the end.
ADCS_API void monolithic(long long steps, double step, const double* inertia, double k_p, double k_v,
                         const double* q_RN, double* state) {
    RigidBody<double> plant;
    PdTracking<double> controller;
    plant.J_B = controller.J_B = Eigen::Map<const Mat3<double>>(inertia);
    controller.k_p = k_p;
    controller.k_v = k_v;
    controller.q_RN = Eigen::Map<const Quat<double>>(q_RN);
    const auto rates = [&](const State& x) {
        plant.q_BN = x.head<4>();
        plant.omega_BN_B = x.tail<3>();
        plant.outputs();
        plant.derivatives();
        State xDot;
        xDot << plant.qDot_BN, plant.omegaDot_BN_B;
        return xDot;
    };
    State x = Eigen::Map<const State>(state);
    for (long long i = 0; i < steps; ++i) {
        controller.q_BN = x.head<4>();
        controller.omega_BN_B = x.tail<3>();
        controller.outputs();
        plant.torque_B = controller.torque_B;
        const State k1 = rates(x);
        const State k2 = rates(x + 0.5 * step * k1);
        const State k3 = rates(x + 0.5 * step * k2);
        const State k4 = rates(x + step * k3);
        x += step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        x.head<4>().normalize();
    }
    Eigen::Map<State>{state} = x;
}
