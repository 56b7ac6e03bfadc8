// The fmi2 functions of one component: those linked into this program, or those of a binary that is loaded.
#pragma once

#include "fmi2Functions.h"

#if defined(_WIN32)
#include <windows.h>
#elif !defined(__wasm__)
#include <dlfcn.h>
#endif

struct Library {
    fmi2InstantiateTYPE* instantiate = fmi2Instantiate;
    fmi2FreeInstanceTYPE* free_instance = fmi2FreeInstance;
    fmi2SetupExperimentTYPE* setup = fmi2SetupExperiment;
    fmi2EnterInitializationModeTYPE* enter_initialization = fmi2EnterInitializationMode;
    fmi2ExitInitializationModeTYPE* exit_initialization = fmi2ExitInitializationMode;
    fmi2GetRealTYPE* get = fmi2GetReal;
    fmi2SetRealTYPE* set = fmi2SetReal;
    fmi2SetIntegerTYPE* set_integer = fmi2SetInteger;
    fmi2DoStepTYPE* do_step = fmi2DoStep;
    fmi2EnterEventModeTYPE* enter_event_mode = fmi2EnterEventMode;
    fmi2NewDiscreteStatesTYPE* new_discrete_states = fmi2NewDiscreteStates;
    fmi2EnterContinuousTimeModeTYPE* enter_continuous_time = fmi2EnterContinuousTimeMode;
    fmi2SetTimeTYPE* set_time = fmi2SetTime;
    fmi2SetContinuousStatesTYPE* set_states = fmi2SetContinuousStates;
    fmi2GetContinuousStatesTYPE* get_states = fmi2GetContinuousStates;
    fmi2GetDerivativesTYPE* get_derivatives = fmi2GetDerivatives;

    /// Of the binary at this path; false if it cannot be loaded.
    bool load([[maybe_unused]] const char* path) {
#if defined(__wasm__)
        return false;
#else
#if defined(_WIN32)
        const auto library = LoadLibraryA(path);
        const auto find = [&](const char* name) { return reinterpret_cast<void*>(GetProcAddress(library, name)); };
#else
        void* library = dlopen(path, RTLD_NOW);
        const auto find = [&](const char* name) { return dlsym(library, name); };
#endif
        if (library == nullptr) return false;
        bool found = true;
        const auto bind = [&](auto& function, const char* name) {
            void* address = find(name);
            found = found && address != nullptr;
            function = reinterpret_cast<std::remove_reference_t<decltype(function)> >(address);
        };
        bind(instantiate, "fmi2Instantiate");
        bind(free_instance, "fmi2FreeInstance");
        bind(setup, "fmi2SetupExperiment");
        bind(enter_initialization, "fmi2EnterInitializationMode");
        bind(exit_initialization, "fmi2ExitInitializationMode");
        bind(get, "fmi2GetReal");
        bind(set, "fmi2SetReal");
        bind(set_integer, "fmi2SetInteger");
        bind(do_step, "fmi2DoStep");
        bind(enter_event_mode, "fmi2EnterEventMode");
        bind(new_discrete_states, "fmi2NewDiscreteStates");
        bind(enter_continuous_time, "fmi2EnterContinuousTimeMode");
        bind(set_time, "fmi2SetTime");
        bind(set_states, "fmi2SetContinuousStates");
        bind(get_states, "fmi2GetContinuousStates");
        bind(get_derivatives, "fmi2GetDerivatives");
        return found;
#endif
    }
};
