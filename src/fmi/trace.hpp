// Host side only: which inputs, states and parameters each output and derivative depends on, found by running the
// law on scalars that remember where they came from. Structural, so nothing cancels by accident; several points,
// so that branches are seen.
#pragma once

#include <array>
#include <bitset>
#include <random>

#include "fmi/model.hpp"

namespace adcs {

/// A set of value references.
struct Bits {
    std::bitset<Table::scalar_capacity> set;
    friend Bits operator+(const Bits& a, const Bits& b) { return {a.set | b.set}; }
    friend Bits scale(double /*factor*/, const Bits& a) { return a; }
};
using Trace = Lifted<Bits>;
using Dependencies = std::array<Bits, Table::scalar_capacity>;  // of each scalar, by value reference

/// What the describe tool prints besides the table.
struct Description {
    const char* summary;
    const char* reference;
    bool differentiable;
    bool sampled;
    Dependencies dependencies;
};
Description describe_model();

template <template <class> class C>
Dependencies trace() {
    constexpr int points = 16;
    Dependencies found{};
    std::mt19937 engine(1);
    std::uniform_real_distribution<double> perturbation(0.0, 0.01);
    for (int point = 0; point < points; ++point) {
        Table table;
        detail::Bound<C, Trace> bound(table);
        for (const Variable& v : table) {
            if (v.type != Type::float64 || v.role == Role::derivative || v.role == Role::held) continue;
            const bool known = v.causality == Causality::independent || v.causality == Causality::parameter ||
                               v.causality == Causality::input || v.role == Role::state;
            for (std::uint32_t e = 0; known && e < v.size; ++e) {
                Trace& x = static_cast<Trace*>(v.data)[e];
                x.value += point == 0 ? 0.0 : perturbation(engine);
                x.tangent.set[v.vr + e] = true;
            }
        }
        bound.evaluate(true, point);
        for (const Variable& v : table) {
            if (v.causality != Causality::output && v.role != Role::derivative) continue;
            for (std::uint32_t e = 0; e < v.size; ++e)
                found[v.vr + e] = found[v.vr + e] + static_cast<Trace*>(v.data)[e].tangent;
        }
    }
    return found;
}

}  // namespace adcs
