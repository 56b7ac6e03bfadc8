// Directional and adjoint derivatives of an instance: exact, at the values that it has.
#include <cmath>

#include "fmi/instance.hpp"

namespace adcs {

template <Addressing A>
Status Instance::expand(const char* function, const std::uint32_t* vrs, std::size_t n, Directional* scalars,
                        std::size_t n_scalars) {
    std::size_t done = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const Scalar* s = find<A>(function, vrs[i]);
        if (s == nullptr) return Status::error;
        const Variable* v = s->variable;
        if (v->type != Type::float64 || (v->role == Role::held && v->causality != Causality::output) ||
            v->causality == Causality::independent) {
            return error("%s: %s has no derivative", function, v->name);
        }
        const std::uint32_t count = count_of<A>(*s);
        if (done + count > n_scalars || done + count > table().next_vr) {
            return error("%s: %zu values given, more expected", function, n_scalars);
        }
        for (std::uint32_t e = 0; e < count; ++e) scalars[done++].vr = vrs[i] + e;
    }
    return done == n_scalars ? Status::ok : error("%s: %zu values given, %zu expected", function, n_scalars, done);
}

/// Finds the `n_known` and `n_unknown` scalars that are meant and brings the values up to date at which they are to be
/// differentiated.
Status Instance::prepare_derivatives(const char* function, Addressing addressing, const std::uint32_t* unknowns,
                                     std::size_t n_unknowns, std::size_t n_unknown, const std::uint32_t* knowns,
                                     std::size_t n_knowns, std::size_t n_known) {
    const auto scalars = addressing == Addressing::scalars ? &Instance::expand<Addressing::scalars>
                                                           : &Instance::expand<Addressing::arrays>;
    Directional* known = known_scalars();
    Directional* unknown = unknown_scalars();
    if (Status status = (this->*scalars)(function, knowns, n_knowns, known, n_known); status != Status::ok)
        return status;
    if (Status status = (this->*scalars)(function, unknowns, n_unknowns, unknown, n_unknown); status != Status::ok)
        return status;
    for (std::size_t i = 0; i < n_known; ++i) {
        const Variable& v = table().variables[table().owner[known[i].vr]];
        if (v.causality != Causality::input && v.causality != Causality::parameter && v.role != Role::state) {
            return error("%s: %s is not an input, state or parameter", function, v.name);
        }
    }
    for (std::size_t i = 0; i < n_unknown; ++i) {
        const Variable& v = table().variables[table().owner[unknown[i].vr]];
        if (v.causality != Causality::output && v.role != Role::derivative) {
            return error("%s: %s is not an output or derivative", function, v.name);
        }
    }
    if (Status status = evaluate_derivatives(); status != Status::ok) return status;
    if (at_sample()) {
        copy_held(held_, false);
        outputs_fresh_ = derivatives_fresh_ = false;
    }
    return Status::ok;
}

/// The derivatives of the prepared unknowns along `known`, in their `value`: all finite, or an error.
Status Instance::differentiate_along(const char* function, const Directional* known, std::size_t n_known,
                                     std::size_t n_unknown) {
    Directional* unknown = unknown_scalars();
    const char* why = model_->differentiate(known, n_known, unknown, n_unknown, clocks_, holding());
    if (why != nullptr) return error("%s: %s", function, why);
    for (std::size_t i = 0; i < n_unknown; ++i) {
        if (std::isfinite(unknown[i].value)) continue;
        const Variable& v = table().variables[table().owner[unknown[i].vr]];
        char name[128];
        element_name(v, unknown[i].vr - v.vr, name, sizeof name);
        return error("at t = %g: the directional derivative of %s%s is %g", time_,
                     v.role == Role::derivative ? "the derivative of " : "", name, unknown[i].value);
    }
    return Status::ok;
}

Status Instance::differentiate(const char* function, Addressing addressing, const std::uint32_t* unknowns,
                               std::size_t n_unknowns, const std::uint32_t* knowns, std::size_t n_knowns,
                               const double* seed, std::size_t n_seed, double* sensitivity, std::size_t n_sensitivity) {
    if ((n_unknowns != 0 && unknowns == nullptr) || (n_knowns != 0 && knowns == nullptr) ||
        (n_seed != 0 && seed == nullptr) || (n_sensitivity != 0 && sensitivity == nullptr)) {
        return null_pointer(function);
    }
    if (Status status =
            prepare_derivatives(function, addressing, unknowns, n_unknowns, n_sensitivity, knowns, n_knowns, n_seed);
        status != Status::ok) {
        return status;
    }
    Directional* known = known_scalars();
    for (std::size_t i = 0; i < n_seed; ++i) known[i].value = seed[i];
    if (Status status = differentiate_along(function, known, n_seed, n_sensitivity); status != Status::ok)
        return status;
    for (std::size_t i = 0; i < n_sensitivity; ++i) sensitivity[i] = unknown_scalars()[i].value;
    return Status::ok;
}

Status Instance::differentiate_adjoint(const char* function, Addressing addressing, const std::uint32_t* unknowns,
                                       std::size_t n_unknowns, const std::uint32_t* knowns, std::size_t n_knowns,
                                       const double* seed, std::size_t n_seed, double* sensitivity,
                                       std::size_t n_sensitivity) {
    if ((n_unknowns != 0 && unknowns == nullptr) || (n_knowns != 0 && knowns == nullptr) ||
        (n_seed != 0 && seed == nullptr) || (n_sensitivity != 0 && sensitivity == nullptr)) {
        return null_pointer(function);
    }
    if (Status status =
            prepare_derivatives(function, addressing, unknowns, n_unknowns, n_seed, knowns, n_knowns, n_sensitivity);
        status != Status::ok) {
        return status;
    }
    Directional* known = known_scalars();
    if (n_sensitivity == 0) return differentiate_along(function, known, 0, n_seed);
    for (std::size_t i = 0; i < n_sensitivity; ++i) {
        const Directional column{known[i].vr, 1.0};
        if (Status status = differentiate_along(function, &column, 1, n_seed); status != Status::ok) return status;
        double sum = 0.0;
        for (std::size_t j = 0; j < n_seed; ++j) sum += seed[j] * unknown_scalars()[j].value;
        if (!std::isfinite(sum)) {
            const Variable& v = table().variables[table().owner[known[i].vr]];
            char name[128];
            element_name(v, known[i].vr - v.vr, name, sizeof name);
            return error("at t = %g: the adjoint derivative by %s is %g", time_, name, sum);
        }
        known[i].value = sum;
    }
    for (std::size_t i = 0; i < n_sensitivity; ++i) sensitivity[i] = known[i].value;
    return Status::ok;
}

}  // namespace adcs
