// The units that components declare, with their SI exponents; angles show in degrees to people.
#pragma once

namespace adcs {

struct Unit {
    const char* name;  ///< "1" for a pure number
    int kg, m, s, rad;
    const Unit* per_second;         ///< unit of the time derivative; nullptr if no state has this unit
    const char* display = nullptr;  ///< unit for people, and how many of it make one of this
    double display_factor = 1.0;
};

namespace unit {

inline constexpr double degrees = 57.295779513082320877;

inline constexpr Unit one_per_s{"1/s", 0, 0, -1, 0, nullptr};
inline constexpr Unit one_per_s2{"1/s2", 0, 0, -2, 0, nullptr};
inline constexpr Unit one{"1", 0, 0, 0, 0, &one_per_s};
inline constexpr Unit s{"s", 0, 0, 1, 0, nullptr};
inline constexpr Unit rad_per_s2{"rad/s2", 0, 0, -2, 1, nullptr, "deg/s2", degrees};
inline constexpr Unit rad_per_s{"rad/s", 0, 0, -1, 1, &rad_per_s2, "deg/s", degrees};
inline constexpr Unit rad{"rad", 0, 0, 0, 1, &rad_per_s, "deg", degrees};
inline constexpr Unit N_m{"N.m", 1, 2, -2, 0, nullptr};
inline constexpr Unit N_m_s{"N.m.s", 1, 2, -1, 0, &N_m};
inline constexpr Unit J{"J", 1, 2, -2, 0, nullptr};
inline constexpr Unit kg_m2{"kg.m2", 1, 2, 0, 0, nullptr};

}  // namespace unit
}  // namespace adcs
