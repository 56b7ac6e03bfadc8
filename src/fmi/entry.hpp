// How both versions of the standard come in: from the pointer that the importing tool holds to an instance that may be
// called now.
#pragma once

#include "fmi/instance.hpp"

namespace adcs {

/// The tool's pointer points to something that begins with this.
struct Handle {
    Instance* instance;
};

inline constexpr unsigned mode_any = mode_instantiated | mode_readable;
inline constexpr unsigned mode_settable = mode_instantiated | mode_initialization | mode_running;

/// The instance if the function may be called now, else nullptr (and the log says so).
inline Instance* enter(void* handle, unsigned modes, const char* function) {
    if (handle == nullptr) return nullptr;
    Instance* instance = static_cast<Handle*>(handle)->instance;
    return instance->allowed(modes, function) ? instance : nullptr;
}

inline Instance* enter(void* handle, unsigned modes, Interface interface, const char* function) {
    Instance* instance = enter(handle, modes, function);
    if (instance == nullptr || instance->interface() == interface) return instance;
    instance->error("%s does not belong to the interface type of this instance", function);
    return nullptr;
}

/// Whether none of the pointers through which a function answers is NULL; else the log says so.
template <class... Pointers>
bool given(Instance* instance, const char* function, const Pointers*... pointers) {
    if (((pointers != nullptr) && ...)) return true;
    instance->null_pointer(function);
    return false;
}

/// For the types of which no component has variables.
inline Status none_of_type(void* handle, const char* function, std::size_t n, const std::uint32_t* vrs) {
    Instance* instance = enter(handle, mode_any, function);
    if (instance == nullptr) return Status::error;
    if (n != 0 && vrs == nullptr) return instance->null_pointer(function);
    return n == 0 ? Status::ok : instance->error("%s: value reference %u has another type", function, vrs[0]);
}

inline Status not_supported(void* handle, const char* function) {
    Instance* instance = enter(handle, mode_any, function);
    return instance == nullptr ? Status::error
                               : instance->error("%s is not supported, see the capability flags", function);
}

}  // namespace adcs
