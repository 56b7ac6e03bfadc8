// Turns one component into the contents of one binary.
#pragma once

#include <cstdlib>
#include <new>

#include "fmi/model.hpp"
#ifdef ADCS_DESCRIBE
#include "fmi/trace.hpp"
#endif

#ifdef ADCS_DESCRIBE
#define ADCS_EXPORT_DESCRIPTION(COMPONENT)                          \
    adcs::Description adcs::describe_model() {                      \
        const adcs::Tracer<COMPONENT> traced;                       \
        return {COMPONENT<double>::summary,                         \
                COMPONENT<double>::reference,                       \
                adcs::detail::is_differentiable<COMPONENT<double>>, \
                adcs::detail::has_sample<COMPONENT<double>>,        \
                adcs::detail::has_outputs<COMPONENT<double>>,       \
                adcs::detail::has_derivatives<COMPONENT<double>>,   \
                traced.dependencies,                                \
                traced.at_start};                                   \
    }
#else
#define ADCS_EXPORT_DESCRIPTION(COMPONENT)
#endif

namespace adcs::detail {

/// Whether a component that draws random numbers draws them under its own name.
template <class C>
constexpr bool draws_as([[maybe_unused]] const char* name) {
    if constexpr (has_stream<C>) {
        return C::stream.is_of(name);
    } else {
        return true;
    }
}

}  // namespace adcs::detail

#define ADCS_EXPORT(COMPONENT)                                                                                         \
    static_assert(adcs::detail::draws_as<adcs::COMPONENT<double>>(#COMPONENT), "stream has another component's name"); \
    adcs::Model* adcs::make_model() {                                                                                  \
        void* memory = std::malloc(sizeof(adcs::ModelOf<adcs::COMPONENT>));                                            \
        return memory == nullptr ? nullptr : new (memory) adcs::ModelOf<adcs::COMPONENT>(#COMPONENT);                  \
    }                                                                                                                  \
    ADCS_EXPORT_DESCRIPTION(adcs::COMPONENT)
