// The units that components declare. Their SI exponents follow from their names; angles show in degrees to people.
//
// One of your own is a line in your header, in namespace adcs: inline constexpr Unit N_m_per_A{"N.m/A"};
#pragma once

#include <cstdio>

namespace adcs {

/// A unit is `factor` of the unit with these exponents.
struct Dimension {
    int kg = 0, m = 0, s = 0, A = 0, K = 0, rad = 0;
    double factor = 1.0;
    bool known = true;  ///< the name is made of symbols
};

namespace detail {

struct Symbol {
    const char* name;
    Dimension dimension;
};

/// What names of units are made of.
inline constexpr Symbol symbols[] = {
    {"1", {}},
    {"kg", {1}},
    {"m", {0, 1}},
    {"s", {0, 0, 1}},
    {"A", {0, 0, 0, 1}},
    {"K", {0, 0, 0, 0, 1}},
    {"rad", {0, 0, 0, 0, 0, 1}},
    {"Hz", {0, 0, -1}},
    {"N", {1, 1, -2}},
    {"Pa", {1, -1, -2}},
    {"J", {1, 2, -2}},
    {"W", {1, 2, -3}},
    {"C", {0, 0, 1, 1}},
    {"V", {1, 2, -3, -1}},
    {"F", {-1, -2, 4, 2}},
    {"ohm", {1, 2, -3, -2}},
    {"S", {-1, -2, 3, 2}},
    {"Wb", {1, 2, -2, -1}},
    {"T", {1, 0, -2, -1}},
    {"H", {1, 2, -2, -2}},
    {"g", {1, 0, 0, 0, 0, 0, 1e-3}},
    {"km", {0, 1, 0, 0, 0, 0, 1e3}},
    {"min", {0, 0, 1, 0, 0, 0, 60.0}},
    {"h", {0, 0, 1, 0, 0, 0, 3600.0}},
    {"deg", {0, 0, 0, 0, 0, 1, 0x1.1df46a2529d39p-6}},   // pi / 180
    {"rpm", {0, 0, -1, 0, 0, 1, 0x1.acee9f37bebd6p-4}},  // pi / 30
    {"%", {0, 0, 0, 0, 0, 0, 1e-2}},
    {"ppm", {0, 0, 0, 0, 0, 0, 1e-6}},
};

/// Not constant, so that a constant unit of such a name does not compile.
inline bool is_not_made_of_known_symbols() { return false; }

constexpr int common_letters(const char* a, const char* b) {
    int n = 0;
    while (a[n] != '\0' && a[n] == b[n]) ++n;
    return n;
}

inline constexpr int n_symbols = sizeof symbols / sizeof symbols[0];

/// Which symbol a text begins with, the longest one; -1 for none. GCC's sanitizer takes no pointer for constant.
constexpr int first_symbol(const char* text) {
    int found = -1, longest = 0;
    for (int i = 0; i < n_symbols; ++i) {
        const int n = common_letters(symbols[i].name, text);
        if (symbols[i].name[n] != '\0' || n <= longest) continue;
        found = i;
        longest = n;
    }
    return found;
}

constexpr void multiply(Dimension& product, const Dimension& by, int exponent) {
    product.kg += exponent * by.kg;
    product.m += exponent * by.m;
    product.s += exponent * by.s;
    product.A += exponent * by.A;
    product.K += exponent * by.K;
    product.rad += exponent * by.rad;
    for (; exponent > 0; --exponent) product.factor *= by.factor;
    for (; exponent < 0; ++exponent) product.factor /= by.factor;
}

/// Of a name such as kg.m2/s or W/(m2.K): symbols with exponents, after the stroke one or several in parentheses.
constexpr Dimension dimension_of(const char* name) {
    Dimension found;
    bool below = false, open = false;
    int symbol = first_symbol(name);
    while (symbol >= 0) {
        name += common_letters(symbols[symbol].name, name);
        int exponent = *name < '0' || *name > '9' ? 1 : 0;
        for (; *name >= '0' && *name <= '9'; ++name) exponent = 10 * exponent + (*name - '0');
        multiply(found, symbols[symbol].dimension, below ? -exponent : exponent);
        if (*name == '/' && !below) {
            below = true;
            open = name[1] == '(';
            name += open ? 2 : 1;
        } else if (*name == '.' && (!below || open)) {
            ++name;
        } else {
            break;
        }
        symbol = first_symbol(name);
    }
    if (open && *name == ')') {
        open = false;
        ++name;
    }
    if (symbol < 0 || open || *name != '\0') found.known = is_not_made_of_known_symbols();
    return found;
}

}  // namespace detail

struct Unit {
    const char* name;  ///< "1" for a pure number
    Dimension dimension;
    const Unit* per_second;  ///< unit of the time derivative; nullptr for one more second below, as N/s of N
    const char* display;     ///< unit for people, and how many of it make one of this; nullptr for none
    double display_factor;

    /// A declaration keeps where a unit is, so none is made in passing.
    explicit constexpr Unit(const char* name_, const Unit* rate = nullptr, const char* shown = nullptr,
                            double of_it = 1.0)
        : Unit(name_, detail::dimension_of(name_), rate, shown, of_it) {}
    /// Of a name that is not made of those symbols, such as packet/s.
    constexpr Unit(const char* name_, const Dimension& exponents, const Unit* rate = nullptr,
                   const char* shown = nullptr, double of_it = 1.0)
        : name(name_), dimension(exponents), per_second(rate), display(shown), display_factor(of_it) {}
};

/// The unit of the time derivative of what has a unit.
class PerSecond {
public:
    explicit PerSecond(const Unit& u) : unit_(u.per_second != nullptr ? *u.per_second : u) {
        if (u.per_second != nullptr) return;
        write(u.name, name_);
        unit_.name = name_;
        if (u.display != nullptr) {
            write(u.display, display_);
            unit_.display = display_;
        }
        --unit_.dimension.s;
    }
    PerSecond(const PerSecond&) = delete;
    PerSecond& operator=(const PerSecond&) = delete;

    const Unit& operator*() const { return unit_; }
    const Unit* operator->() const { return &unit_; }

private:
    using Text = char[64];

    /// N/s of N, m/s3 of m/s2, N/(m.s) of N/m, and W/(K.s2) of W/(K.s).
    static void write(const char* name, Text& text) {
        const char *stroke = nullptr, *last = name, *end = name;
        for (; *end != '\0'; ++end) {
            if (*end == '/') stroke = end;
            if (*end == '/' || *end == '.' || *end == '(') last = end + 1;
        }
        if (stroke == nullptr) {
            std::snprintf(text, sizeof text, "%s/s", name);
            return;
        }
        const bool open = stroke[1] == '(';
        if (open) --end;
        int exponent = 0, digits = 0;
        for (const char* c = last + 1; c < end && *c >= '0' && *c <= '9'; ++c, ++digits) {
            exponent = 10 * exponent + (*c - '0');
        }
        const int before = static_cast<int>(last - name), all = static_cast<int>(end - name);
        const char* closing = open ? ")" : "";
        if (*last == 's' && last + 1 + digits == end) {
            std::snprintf(text, sizeof text, "%.*ss%d%s", before, name, digits == 0 ? 2 : exponent + 1, closing);
        } else if (open) {
            std::snprintf(text, sizeof text, "%.*s.s)", all, name);
        } else {
            std::snprintf(text, sizeof text, "%.*s(%s.s)", before, name, last);
        }
    }

    Unit unit_;
    Text name_{}, display_{};
};

namespace unit {

inline constexpr double degrees = 57.295779513082320877;

// numbers
inline constexpr Unit one{"1"};
inline constexpr Unit percent{"%"};
inline constexpr Unit ppm{"ppm"};
// time
inline constexpr Unit s{"s", &one};
inline constexpr Unit s2{"s2", &s};
inline constexpr Unit min{"min"};
inline constexpr Unit h{"h"};
inline constexpr Unit one_per_s{"1/s"};
inline constexpr Unit one_per_s2{"1/s2"};
inline constexpr Unit Hz{"Hz"};
// angles
inline constexpr Unit rad{"rad", nullptr, "deg", degrees};
inline constexpr Unit rad_per_s{"rad/s", nullptr, "deg/s", degrees};
inline constexpr Unit rad_per_s2{"rad/s2", nullptr, "deg/s2", degrees};
inline constexpr Unit rad_per_s3{"rad/s3", nullptr, "deg/s3", degrees};
inline constexpr Unit rad2{"rad2"};
inline constexpr Unit rad2_per_s{"rad2/s"};
inline constexpr Unit rad2_per_s2{"rad2/s2"};
inline constexpr Unit rad2_per_s3{"rad2/s3"};
inline constexpr Unit deg{"deg"};
inline constexpr Unit deg_per_s{"deg/s"};
inline constexpr Unit deg_per_h{"deg/h"};
inline constexpr Unit rpm{"rpm"};
// lengths and motion
inline constexpr Unit m{"m"};
inline constexpr Unit m2{"m2"};
inline constexpr Unit m3{"m3"};
inline constexpr Unit m4{"m4"};
inline constexpr Unit km{"km"};
inline constexpr Unit one_per_m{"1/m"};
inline constexpr Unit m_per_s{"m/s"};
inline constexpr Unit m_per_s2{"m/s2"};
inline constexpr Unit m_per_s3{"m/s3"};
inline constexpr Unit km_per_s{"km/s"};
inline constexpr Unit m2_per_s{"m2/s"};
inline constexpr Unit m2_per_s2{"m2/s2"};
inline constexpr Unit m2_per_s3{"m2/s3"};
inline constexpr Unit m3_per_s{"m3/s"};
inline constexpr Unit m3_per_s2{"m3/s2"};
// masses
inline constexpr Unit kg{"kg"};
inline constexpr Unit kg_per_s{"kg/s"};
inline constexpr Unit kg_m{"kg.m"};
inline constexpr Unit kg_m2{"kg.m2"};
inline constexpr Unit kg_m2_per_s{"kg.m2/s"};
inline constexpr Unit kg_m_per_s{"kg.m/s"};
inline constexpr Unit kg_per_m{"kg/m"};
inline constexpr Unit kg_per_m2{"kg/m2"};
inline constexpr Unit kg_per_m3{"kg/m3"};
inline constexpr Unit kg2_m4_per_s{"kg2.m4/s"};
inline constexpr Unit kg_m2_s{"kg.m2.s"};
inline constexpr Unit kg_m2_s2{"kg.m2.s2"};
inline constexpr Unit kg_s2_per_m2{"kg.s2/m2"};
inline constexpr Unit s4_per_kg_m2{"s4/(kg.m2)"};
inline constexpr Unit one_per_kg{"1/kg"};
inline constexpr Unit one_per_kg_m2{"1/(kg.m2)"};
inline constexpr Unit one_per_kg_m2_s{"1/(kg.m2.s)"};
inline constexpr Unit s2_per_kg2_m4{"s2/(kg2.m4)"};
// forces, torques, energy
inline constexpr Unit N{"N"};
inline constexpr Unit N_s{"N.s", &N};
inline constexpr Unit N_per_m{"N/m"};
inline constexpr Unit N_s_per_m{"N.s/m", &N_per_m};
inline constexpr Unit N_m{"N.m"};
inline constexpr Unit N_m_s{"N.m.s", &N_m};
inline constexpr Unit N_m_per_s{"N.m/s"};
inline constexpr Unit N_m_per_rad{"N.m/rad"};
inline constexpr Unit N_m_s_per_rad{"N.m.s/rad", &N_m_per_rad};
inline constexpr Unit Pa{"Pa"};
inline constexpr Unit W{"W"};
inline constexpr Unit J{"J", &W};
inline constexpr Unit W_h{"W.h"};
inline constexpr Unit W_per_m2{"W/m2"};
// temperature and heat
inline constexpr Unit K{"K"};
inline constexpr Unit one_per_K{"1/K"};
inline constexpr Unit K_per_W{"K/W"};
inline constexpr Unit W_per_K{"W/K"};
inline constexpr Unit J_per_K{"J/K", &W_per_K};
inline constexpr Unit J_per_kg_K{"J/(kg.K)"};
inline constexpr Unit W_per_m_K{"W/(m.K)"};
inline constexpr Unit W_per_m2_K{"W/(m2.K)"};
inline constexpr Unit W_per_m2_K4{"W/(m2.K4)"};
// electricity and magnetism
inline constexpr Unit A{"A"};
inline constexpr Unit A_per_m{"A/m"};
inline constexpr Unit A_m2{"A.m2"};
inline constexpr Unit A_h{"A.h"};
inline constexpr Unit C{"C", &A};
inline constexpr Unit V{"V"};
inline constexpr Unit V_s_per_rad{"V.s/rad"};
inline constexpr Unit N_m_per_A{"N.m/A"};
inline constexpr Unit ohm{"ohm"};
inline constexpr Unit F{"F"};
inline constexpr Unit H{"H"};
inline constexpr Unit Wb{"Wb", &V};
inline constexpr Unit T{"T", nullptr, "uT", 1e6};
inline constexpr Unit T_per_s{"T/s", nullptr, "uT/s", 1e6};
inline constexpr Unit T_m2{"T.m2", &V};
inline constexpr Unit T_per_A{"T/A"};

}  // namespace unit
}  // namespace adcs
