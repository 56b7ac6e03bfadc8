// All components in one program, in double only.
#pragma once

#include <cstdlib>
#include <new>

#include "fmi/model.hpp"

struct Component {
    const char* name;
    adcs::Model* (*make)();
};
/// Ends with one without a name. Its text is made from the list of components.
extern const Component components[];
/// The one that adcs::make_model() makes, and with it the fmi2 functions linked into this program.
extern const Component* selected;

template <template <class> class C>
adcs::Model* make(const char* name) {
    using Model = adcs::ModelOf<C, false>;
    void* memory = std::malloc(sizeof(Model));
    return memory == nullptr ? nullptr : new (memory) Model(name);
}
