// Turns one component into the contents of one binary.
#pragma once

#include <cstdlib>
#include <new>

#include "fmi/model.hpp"
#ifdef ADCS_DESCRIBE
#include "fmi/describe.hpp"
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

#define ADCS_CHECK(COMPONENT)                                               \
    static_assert(adcs::detail::is_well_formed<adcs::COMPONENT<double>>()); \
    static_assert(adcs::detail::draws_as<adcs::COMPONENT<double>>(#COMPONENT), "stream has another component's name")

#ifdef ADCS_DESCRIBE
#define ADCS_EXPORT(COMPONENT) \
    ADCS_CHECK(COMPONENT);     \
    int main() { return adcs::describe<adcs::COMPONENT>(#COMPONENT); }
#else
#define ADCS_EXPORT(COMPONENT)                                                                        \
    ADCS_CHECK(COMPONENT);                                                                            \
    adcs::Model* adcs::make_model() {                                                                 \
        void* memory = std::malloc(sizeof(adcs::ModelOf<adcs::COMPONENT>));                           \
        return memory == nullptr ? nullptr : new (memory) adcs::ModelOf<adcs::COMPONENT>(#COMPONENT); \
    }
#endif
