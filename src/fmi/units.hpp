// The units that components declare, with their SI exponents; angles show in degrees to people.
#pragma once

namespace adcs {

struct Unit {
    const char* name;               ///< "1" for a pure number
    int kg, m, s, rad;              ///< and A, below
    const Unit* per_second;         ///< unit of the time derivative; nullptr if no state has this unit
    const char* display = nullptr;  ///< unit for people, and how many of it make one of this
    double display_factor = 1.0;
    int A = 0;
};

namespace unit {

inline constexpr double degrees = 57.295779513082320877;

inline constexpr Unit one_per_s2{"1/s2", 0, 0, -2, 0, nullptr};
inline constexpr Unit one_per_s{"1/s", 0, 0, -1, 0, &one_per_s2};
inline constexpr Unit one{"1", 0, 0, 0, 0, &one_per_s};
inline constexpr Unit s{"s", 0, 0, 1, 0, &one};
inline constexpr Unit rad_per_s2{"rad/s2", 0, 0, -2, 1, nullptr, "deg/s2", degrees};
inline constexpr Unit rad_per_s{"rad/s", 0, 0, -1, 1, &rad_per_s2, "deg/s", degrees};
inline constexpr Unit rad{"rad", 0, 0, 0, 1, &rad_per_s, "deg", degrees};
inline constexpr Unit N_m{"N.m", 1, 2, -2, 0, nullptr};
inline constexpr Unit N_m_s{"N.m.s", 1, 2, -1, 0, &N_m};
inline constexpr Unit W{"W", 1, 2, -3, 0, nullptr};
inline constexpr Unit J{"J", 1, 2, -2, 0, &W};
inline constexpr Unit kg_m2_per_s{"kg.m2/s", 1, 2, -1, 0, nullptr};
inline constexpr Unit kg_m2{"kg.m2", 1, 2, 0, 0, &kg_m2_per_s};
inline constexpr Unit N_m_per_s{"N.m/s", 1, 2, -3, 0, nullptr};
inline constexpr Unit kg2_m4_per_s{"kg2.m4/s", 2, 4, -1, 0, nullptr};
inline constexpr Unit kg_m2_s{"kg.m2.s", 1, 2, 1, 0, nullptr};
inline constexpr Unit kg_m2_s2{"kg.m2.s2", 1, 2, 2, 0, nullptr};
inline constexpr Unit kg_s2_per_m2{"kg.s2/m2", 1, -2, 2, 0, nullptr};
inline constexpr Unit s4_per_kg_m2{"s4/(kg.m2)", -1, -2, 4, 0, nullptr};
inline constexpr Unit s2{"s2", 0, 0, 2, 0, nullptr};
inline constexpr Unit one_per_kg_m2_s{"1/(kg.m2.s)", -1, -2, -1, 0, nullptr};
inline constexpr Unit one_per_kg_m2{"1/(kg.m2)", -1, -2, 0, 0, &one_per_kg_m2_s};
inline constexpr Unit s2_per_kg2_m4{"s2/(kg2.m4)", -2, -4, 2, 0, nullptr};
inline constexpr Unit m_per_s2{"m/s2", 0, 1, -2, 0, nullptr};
inline constexpr Unit m_per_s{"m/s", 0, 1, -1, 0, &m_per_s2};
inline constexpr Unit m{"m", 0, 1, 0, 0, &m_per_s};
inline constexpr Unit m2{"m2", 0, 2, 0, 0, nullptr};
inline constexpr Unit kg_per_s{"kg/s", 1, 0, -1, 0, nullptr};
inline constexpr Unit kg{"kg", 1, 0, 0, 0, &kg_per_s};
inline constexpr Unit kg_per_m3{"kg/m3", 1, -3, 0, 0, nullptr};
inline constexpr Unit m3_per_s2{"m3/s2", 0, 3, -2, 0, nullptr};
inline constexpr Unit N{"N", 1, 1, -2, 0, nullptr};
inline constexpr Unit N_s{"N.s", 1, 1, -1, 0, &N};
inline constexpr Unit T{"T", 1, 0, -2, 0, nullptr, "uT", 1e6, -1};

}  // namespace unit
}  // namespace adcs
