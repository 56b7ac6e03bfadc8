// Host side only: which inputs, states and parameters each output and derivative depends on, found by running the
// law on scalars that remember where they came from. Structural, so nothing cancels by accident; several points,
// so that branches are seen.
#pragma once

#include <array>
#include <bitset>
#include <cstring>
#include <random>

#include "fmi/model.hpp"
#include "fmi/values.hpp"

namespace adcs {

/// A set of value references.
struct Bits {
    std::bitset<Table::scalar_capacity> set;
    friend Bits operator+(const Bits& a, const Bits& b) { return {a.set | b.set}; }
    friend Bits scale(double /*factor*/, const Bits& a) { return a; }
    friend Bits scale_steeply(double /*slope*/, const Bits& a) { return a; }
    friend Bits chosen(const Bits& a, const Bits& other) { return a + other; }
};
/// What was decided by since it was emptied. A decision is no number that could carry it: what is no number itself, a
/// Boolean output for one, may come of any of them.
inline Bits decisions;
inline void decided_by(const Bits& a) { decisions = decisions + a; }
using Trace = Lifted<Bits>;

/// Whether something holds, and what that depends on, which select() adds to what it chooses from.
struct Condition {
    bool holds;
    Bits from;
    operator bool() const {  // NOLINT(google-explicit-constructor): laws branch on it, too
        decided_by(from);
        return holds;
    }
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

/// Runs a component at points around its start values, with Booleans, integers and enumerations at their start values and
/// at others, and with quaternions of both signs.
template <template <class> class C>
class Tracer {
public:
    Tracer() {
        for (int point = 0; point < points; ++point) {
            const Run run(point, point);
            for (const Variable& v : run.table) {
                for (std::uint32_t e = 0; is_unknown(v) && e < v.size; ++e) {
                    const Bits& found =
                        v.type == Type::float64 ? static_cast<const Trace*>(v.data)[e].tangent : run.decided;
                    dependencies[v.vr + e] = dependencies[v.vr + e] + found;
                }
            }
            // An integer has no derivative, and the index of a sample no reference: what differs, depends.
            for (const Variable& v : run.table) {
                for (std::uint32_t by = 1; is_chosen(v) && by < values_of(v); ++by)
                    add(dependencies, run, Run(point, point, v.vr, by), v.vr);
            }
            for (const std::uint32_t vr : timing_) add(at_start, run, Run(point, point + 1), vr);
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

    /// Whether it takes one value after another, and is given.
    static bool is_chosen(const Variable& v) {
        return v.type != Type::float64 && (v.causality == Causality::parameter || v.causality == Causality::input);
    }
    /// How many values of it are tried; of an integer there are two.
    static std::uint32_t values_of(const Variable& v) { return v.type == Type::enumeration ? v.n_items : 2; }
    /// The value that is `by` values further.
    static double other_value(const Variable& v, std::uint32_t by) {
        const double value = number_of<Trace>(v, 0);
        if (v.type == Type::int32) return value + (by % 2 == 0 ? 0.0 : value < v.max ? 1.0 : -1.0);
        return static_cast<std::uint32_t>(value + by) % values_of(v);
    }

    /// Everything evaluated at one point, where what has the reference `changed` has a value that is `by` values further.
    struct Run {
        Run(int point, int k, std::uint32_t changed = none, std::uint32_t by = 0) : bound(table) {
            std::mt19937 engine(static_cast<unsigned>(point) + 1);
            std::uniform_real_distribution<double> perturbation(0.0, 0.01);
            unsigned others = static_cast<unsigned>(point);  // bit by bit, what has its other value, or its other sign
            const auto is_other = [&others] {
                const bool other = (others & 1U) != 0;
                others >>= 1;
                return other;
            };
            for (const Variable& v : table) {
                if (is_chosen(v))
                    set_number<Trace>(v, 0, other_value(v, (is_other() ? 1U : 0U) + (v.vr == changed ? by : 0U)));
                if (v.type != Type::float64) continue;
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
            const Clocks clocks = all_due(bound.clocks(), k, point < points / 2);
            decisions = {};
            bound.evaluate(clocks, 0);
            decided = decisions;
        }

        Table table;
        Bits decided;
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
                if (differs(v, other.table.variables[i], e)) found[v.vr + e].set[known] = true;
            }
        }
    }

    static bool differs(const Variable& one, const Variable& other, std::uint32_t e) {
        if (one.type == Type::string)
            return std::strcmp(*static_cast<const char* const*>(one.data),
                               *static_cast<const char* const*>(other.data)) != 0;
        return number_of<Trace>(one, e) != number_of<Trace>(other, e);
    }

    static Timing timing() {
        Timing found;
        Run run(1, 0);
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
