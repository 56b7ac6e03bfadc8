// How both versions of the standard come in: from the pointer that the importing tool holds to an instance that may be
// called now.
#pragma once

#include <type_traits>

#include "fmi/instance.hpp"

namespace adcs {

/// The tool's pointer points to something that begins with this.
struct Handle {
    Instance* instance;
};

inline constexpr unsigned mode_any = mode_instantiated | mode_readable;
inline constexpr unsigned mode_settable = mode_instantiated | mode_initialization | mode_running;

/// A status as either version of the standard has it: the numbers are the same.
struct Answer {
    Status status;
    template <class FmiStatus>
    operator FmiStatus() const {  // NOLINT(google-explicit-constructor): what is returned is said by each function
        return static_cast<FmiStatus>(status);
    }
};

namespace detail {

template <class Action>
Status carry_out(const Action& action, Instance& instance, const char* function) {
    if constexpr (std::is_invocable_v<Action, Instance&>) {
        return action(instance);
    } else {
        return action(instance, function);
    }
}

}  // namespace detail

/// Does what an FMI function is for, action(instance), if it may be called now; else the log says why not. An action whose
/// messages name the function, action(instance, function), is given its name.
template <class Action>
Answer call(void* handle, unsigned modes, const char* function, const Action& action) {
    if (handle == nullptr) return {Status::error};
    Instance& instance = *static_cast<Handle*>(handle)->instance;
    return {instance.allowed(modes, function) ? detail::carry_out(action, instance, function) : Status::error};
}

/// Of a function that only instances of one interface type have.
template <class Action>
Answer call(void* handle, unsigned modes, Interface interface, const char* function, const Action& action) {
    return call(handle, modes, function, [&](Instance& instance) {
        if (instance.interface() != interface)
            return instance.error("%s does not belong to the interface type of this instance", function);
        return detail::carry_out(action, instance, function);
    });
}

/// Whether none of the pointers through which a function answers is NULL; else the log says so.
template <class... Pointers>
bool given(Instance& instance, const char* function, const Pointers*... pointers) {
    if (((pointers != nullptr) && ...)) return true;
    instance.null_pointer(function);
    return false;
}

/// For the types of which no component has variables.
inline Answer none_of_type(void* handle, const char* function, std::size_t n, const std::uint32_t* vrs) {
    return call(handle, mode_any, function, [&](Instance& instance) {
        if (n != 0 && vrs == nullptr) return instance.null_pointer(function);
        return n == 0 ? Status::ok : instance.error("%s: value reference %u has another type", function, vrs[0]);
    });
}

inline Answer not_supported(void* handle, const char* function) {
    return call(handle, mode_any, function, [&](Instance& instance) {
        return instance.error("%s is not supported, see the capability flags", function);
    });
}

}  // namespace adcs
