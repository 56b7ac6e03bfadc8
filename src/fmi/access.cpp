// Getting and setting values of an instance: which references are known, what may be set when, and to what.
#include <cmath>
#include <cstdio>

#include "fmi/conditions.hpp"
#include "fmi/instance.hpp"
#include "fmi/values.hpp"

namespace adcs {
namespace {

bool all_finite(const double* values, std::size_t n) {
    double zero = 0.0;
    for (std::size_t i = 0; i < n; ++i) zero += 0.0 * values[i];
    return zero == 0.0;
}

template <class Value>
double as_number(Value value) {
    return static_cast<double>(value);
}
double as_number(const char* /*text*/) { return 0.0; }  // none is ever set

template <class Value, class Stored>
Value as_passed(Stored stored) {
    return static_cast<Value>(stored);
}
template <>
const char* as_passed(const char* text) {
    return text != nullptr ? text : "";
}

}  // namespace

void element_name(const Variable& v, std::uint32_t element, char* buffer, std::size_t size) {
    if (v.rows == 0) {
        std::snprintf(buffer, size, "%s", v.name);
    } else if (v.cols == 0) {
        std::snprintf(buffer, size, "%s[%u]", v.name, element + 1);
    } else {
        std::snprintf(buffer, size, "%s[%u,%u]", v.name, element / v.cols + 1, element % v.cols + 1);
    }
}

/// Whether all references are known and stand for so many values; `traits` is what any of them has.
template <Addressing A>
bool Instance::scan(const std::uint32_t* vrs, std::size_t n, std::size_t n_values, unsigned* traits) const {
    const Scalar* scalars = scalars_;
    const std::uint32_t n_scalars = n_scalars_;
    std::size_t count = 0;
    unsigned any = 0;
    for (std::size_t i = 0; i < n; ++i) {
        if (vrs[i] >= n_scalars || count_of<A>(scalars[vrs[i]]) == 0) return false;
        any |= scalars[vrs[i]].traits;
        count += count_of<A>(scalars[vrs[i]]);
    }
    *traits = any;
    return count == n_values;
}

/// What is wrong with references that are not to be read.
template <Addressing A, class P>
Status Instance::check_references(const char* function, const std::uint32_t* vrs, std::size_t n, std::size_t n_values) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const Scalar* s = find<A>(function, vrs[i]);
        if (s == nullptr) return Status::error;
        if ((s->traits & P::traits) == 0) {
            return error("%s: %s has another type", function, s->variable->name);
        }
        count += count_of<A>(*s);
    }
    return count == n_values ? Status::ok : error("%s: %zu values given, %zu expected", function, n_values, count);
}

template <Addressing A, class P>
Status Instance::get(const char* function, const std::uint32_t* vrs, std::size_t n, typename P::Value* values,
                     std::size_t n_values) {
    if ((vrs == nullptr && n != 0) || (values == nullptr && n_values != 0)) return null_pointer(function);
    unsigned traits = 0;
    if (!scan<A>(vrs, n, n_values, &traits) || (traits & trait_types & ~P::traits) != 0) {
        return check_references<A, P>(function, vrs, n, n_values);
    }
    if (mode_ != mode_instantiated) {  // before initialization nothing is computed yet
        if ((traits & trait_rate) != 0 && !derivatives_fresh_) {
            if (Status status = evaluate_derivatives(); status != Status::ok) return status;
        } else if ((traits & trait_computed) != 0 && !outputs_fresh_) {
            if (Status status = evaluate(); status != Status::ok) return status;
        } else if ((traits & trait_state) != 0) {
            if (Status status = check_parameters(); status != Status::ok) return status;
        }
    }
    const Scalar* scalars = scalars_;
    for (std::size_t i = 0; i < n; ++i) {
        const Scalar& s = scalars[vrs[i]];
        const auto* from = static_cast<const typename P::Stored*>(s.data);
        for (std::uint32_t e = 0; e < count_of<A>(s); ++e) *values++ = as_passed<typename P::Value>(from[e]);
    }
    return Status::ok;
}

bool Instance::may_set(const char* function, const Scalar& s) {
    const unsigned wanted =
        (mode_ & (mode_instantiated | mode_initialization)) != 0 ? trait_set_early : trait_set_running;
    if ((s.traits & wanted) != 0) return true;
    error("%s: %s can not be set %s", function, s.variable->name,
          (s.traits & trait_set_early) != 0 ? "after initialization" : "because the component computes it");
    return false;
}

bool Instance::in_range(const char* function, const Variable& v, std::uint32_t element, double value) {
    const bool is_listed = v.type == Type::enumeration ? is_item(v, value)
                           : v.type == Type::boolean   ? value == 0.0 || value == 1.0
                                                       : true;
    if (std::isfinite(value) && is_listed && value > v.above && value >= v.min && value <= v.max) return true;
    char name[128];
    element_name(v, element, name, sizeof name);
    if (v.type == Type::enumeration) {
        char items[256];
        list_items(v, items, sizeof items);
        error("%s: %s = %.17g refused: one of its items is expected, %s", function, name, value, items);
    } else if (v.type == Type::boolean) {
        error("%s: %s = %.17g refused: 0 or 1 is expected", function, name, value);
    } else if (!std::isfinite(value)) {
        error("%s: %s = %g refused: a finite number is expected", function, name, value);
    } else if (!(value > v.above)) {
        error("%s: %s = %g refused: must be above %g", function, name, value, v.above);
    } else if (!(value >= v.min)) {
        error("%s: %s = %g refused: must be at least %g", function, name, value, v.min);
    } else {
        error("%s: %s = %g refused: must be at most %g", function, name, value, v.max);
    }
    return false;
}

template <Addressing A, class P>
Status Instance::check_values(const char* function, const std::uint32_t* vrs, std::size_t n,
                              const typename P::Value* values, std::size_t n_values) {
    std::size_t done = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const Scalar* s = find<A>(function, vrs[i]);
        if (s == nullptr) return Status::error;
        const Variable& v = *s->variable;
        if ((s->traits & P::traits) == 0) return error("%s: %s has another type", function, v.name);
        if (!may_set(function, *s)) return Status::error;
        const std::uint32_t count = count_of<A>(*s);
        if (done + count > n_values) return error("%s: %zu values given, more expected", function, n_values);
        for (std::uint32_t e = 0; e < count; ++e) {
            if (!in_range(function, v, vrs[i] - v.vr + e, as_number(values[done + e]))) return Status::error;
        }
        done += count;
    }
    return done == n_values ? Status::ok : error("%s: %zu values given, %zu expected", function, n_values, done);
}

template <Addressing A, class P>
Status Instance::set(const char* function, const std::uint32_t* vrs, std::size_t n, const typename P::Value* values,
                     std::size_t n_values) {
    if ((vrs == nullptr && n != 0) || (values == nullptr && n_values != 0)) return null_pointer(function);
    // What an importer sets in its loop are finite values of plain inputs: nothing else needs a closer look.
    unsigned traits = 0;
    bool plain = false;
    if constexpr (std::is_same_v<P, Floats>) {
        plain = scan<A>(vrs, n, n_values, &traits) && (traits & trait_not_plain) == 0 && all_finite(values, n_values);
    }
    if (!plain) {  // all values are checked before the first one is stored
        const Status status = check_values<A, P>(function, vrs, n, values, n_values);
        if (status != Status::ok) return status;
        parameters_checked_ = false;
    }
    const Scalar* scalars = scalars_;
    for (std::size_t i = 0; i < n; ++i) {
        const Scalar& s = scalars[vrs[i]];
        auto* to = static_cast<typename P::Stored*>(s.data);
        for (std::uint32_t e = 0; e < count_of<A>(s); ++e) to[e] = static_cast<typename P::Stored>(*values++);
    }
    // scan() may have given up before the end, but then everything is to be checked again
    inputs_checked_ = inputs_checked_ && plain && (traits & trait_checked) == 0;
    outputs_fresh_ = derivatives_fresh_ = false;
    return Status::ok;
}

#define ADCS_VALUES(ADDRESSING, PASSED)                                                                               \
    template Status Instance::get<ADDRESSING, PASSED>(const char*, const std::uint32_t*, std::size_t, PASSED::Value*, \
                                                      std::size_t);                                                   \
    template Status Instance::set<ADDRESSING, PASSED>(const char*, const std::uint32_t*, std::size_t,                 \
                                                      const PASSED::Value*, std::size_t);
ADCS_VALUES(Addressing::scalars, Floats)
ADCS_VALUES(Addressing::scalars, fmi2::IntegersAndItems)
ADCS_VALUES(Addressing::scalars, fmi2::Booleans)
ADCS_VALUES(Addressing::scalars, Texts)
ADCS_VALUES(Addressing::arrays, Floats)
ADCS_VALUES(Addressing::arrays, Integers)
ADCS_VALUES(Addressing::arrays, fmi3::EnumerationItems)
ADCS_VALUES(Addressing::arrays, fmi3::Booleans)
ADCS_VALUES(Addressing::arrays, Texts)
#undef ADCS_VALUES

}  // namespace adcs
