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
    friend Bits scale_steeply(double /*slope*/, const Bits& a) { return a; }
    friend Bits chosen(const Bits& a, const Bits& other) { return a + other; }
};
using Trace = Lifted<Bits>;

/// Whether something holds, and what that depends on, which select() adds to what it chooses from.
struct Condition {
    bool holds;
    Bits from;
    operator bool() const { return holds; }  // NOLINT(google-explicit-constructor): laws branch on it, too
    friend Condition operator!(const Condition& a) { return {!a.holds, a.from}; }
    friend Condition operator&&(const Condition& a, const Condition& b) {
        return {a.holds && b.holds, a.from + b.from};
    }
    friend Condition operator||(const Condition& a, const Condition& b) {
        return {a.holds || b.holds, a.from + b.from};
    }
    friend Condition operator&&(const Condition& a, bool b) { return {a.holds && b, a.from}; }
    friend Condition operator||(const Condition& a, bool b) { return {a.holds || b, a.from}; }
    friend Condition operator&&(bool a, const Condition& b) { return b && a; }
    friend Condition operator||(bool a, const Condition& b) { return b || a; }
};
inline Condition compared(bool holds, const Bits& a, const Bits& b) { return {holds, a + b}; }

template <class A, class B,
          std::enable_if_t<std::is_convertible_v<A, Trace> && std::is_convertible_v<B, Trace>, int> = 0>
Trace select(const Condition& condition, const A& a, const B& b) {
    const Trace either = select(condition.holds, Trace(a), Trace(b));
    return {either.value, either.tangent + condition.from};
}

using Dependencies = std::array<Bits, Table::scalar_capacity>;  // of each scalar, by value reference

/// Runs a component at points around its start values, with integer parameters at their start values and at others, and
/// with quaternions of both signs.
template <template <class> class C>
class Tracer {
public:
    Tracer() {
        for (int point = 0; point < points; ++point) {
            const Run run(point, point, none);
            for (const Variable& v : run.table) {
                for (std::uint32_t e = 0; is_unknown(v) && e < v.size; ++e) {
                    dependencies[v.vr + e] = dependencies[v.vr + e] + static_cast<const Trace*>(v.data)[e].tangent;
                }
            }
            // An integer has no derivative, and the index of a sample no reference: what differs, depends.
            for (const Variable& v : run.table) {
                if (v.type == Type::int32) add(dependencies, run, Run(point, point, v.vr), v.vr);
            }
            for (const std::uint32_t vr : timing_) add(at_start, run, Run(point, point + 1, none), vr);
        }
    }

    Dependencies dependencies{}, at_start{};

private:
    static constexpr int points = 16;
    static constexpr std::uint32_t none = Table::scalar_capacity;

    /// Parameters of which the index of the sample that is taken at the start is a function, and time.
    struct Timing {
        std::uint32_t vrs[Table::scalar_capacity];
        std::uint32_t count = 0;
        const std::uint32_t* begin() const { return vrs; }
        const std::uint32_t* end() const { return vrs + count; }
    };

    /// Everything evaluated at one point; the integer parameter `changed` has its other value.
    struct Run {
        Run(int point, int k, std::uint32_t changed) : bound(table) {
            std::mt19937 engine(static_cast<unsigned>(point) + 1);
            std::uniform_real_distribution<double> perturbation(0.0, 0.01);
            unsigned others = static_cast<unsigned>(point);  // bit by bit, what has its other value, or its other sign
            const auto is_other = [&others] {
                const bool other = (others & 1U) != 0;
                others >>= 1;
                return other;
            };
            for (const Variable& v : table) {
                if (v.type == Type::int32) {
                    if (is_other() != (v.vr == changed))
                        *static_cast<std::int32_t*>(v.data) += *static_cast<std::int32_t*>(v.data) < v.max ? 1 : -1;
                    continue;
                }
                if (v.role == Role::derivative || v.role == Role::held) continue;
                const bool known = v.causality == Causality::independent || v.causality == Causality::parameter ||
                                   v.causality == Causality::input || v.role == Role::state;
                const double sign = known && v.kind == Kind::unit_quaternion && is_other() ? -1.0 : 1.0;
                for (std::uint32_t e = 0; known && e < v.size; ++e) {
                    Trace& x = static_cast<Trace*>(v.data)[e];
                    x.value = sign * (x.value + (point == 0 ? 0.0 : perturbation(engine)));
                    x.tangent.set[v.vr + e] = true;
                }
            }
            bound.evaluate(all_due(bound.clocks(), k, point < points / 2), 0);
        }

        Table table;
        detail::Bound<C, Trace> bound;
    };

    static bool is_unknown(const Variable& v) {
        return v.causality == Causality::output || v.role == Role::derivative || v.role == Role::event;
    }

    static void add(Dependencies& found, const Run& one, const Run& other, std::uint32_t known) {
        for (int i = 0; i < one.table.count; ++i) {
            const Variable& v = one.table.variables[i];
            if (!is_unknown(v)) continue;
            for (std::uint32_t e = 0; e < v.size; ++e) {
                const double a = static_cast<const Trace*>(v.data)[e].value;
                const double b = static_cast<const Trace*>(other.table.variables[i].data)[e].value;
                if (a != b) found[v.vr + e].set[known] = true;
            }
        }
    }

    static Timing timing() {
        Timing found;
        Run run(1, 0, none);
        if (run.table.clocks == 0) return found;
        found.vrs[found.count++] = 0;
        const Clocks before = run.bound.clocks();
        for (const Variable& v : run.table) {
            if (v.type != Type::float64 || v.causality != Causality::parameter) continue;
            for (std::uint32_t e = 0; e < v.size; ++e) {
                Trace& x = static_cast<Trace*>(v.data)[e];
                const Trace value = x;
                x.value += 1.0;
                const Clocks after = run.bound.clocks();
                for (int i = 0; i < before.count(); ++i) {
                    if (after[i].period == before[i].period && after[i].offset == before[i].offset) continue;
                    found.vrs[found.count++] = v.vr + e;
                    break;
                }
                x = value;
            }
        }
        return found;
    }

    const Timing timing_ = timing();
};

}  // namespace adcs
