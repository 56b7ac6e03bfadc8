// What an instance tells the importing tool.
#pragma once

#include <cstdarg>
#include <cstddef>

#include "fmi/compiler.hpp"

namespace adcs {

enum class Status : int { ok, warning, discard, error, fatal };  // the numbers of fmi2Status and fmi3Status

/// Where messages go; `category` is one of log_categories.
struct Log {
    void (*write)(void* context, Status status, const char* category, const char* message) = nullptr;
    void* context = nullptr;
};

struct LogCategory {
    const char* name;
    const char* description;
};
inline constexpr LogCategory log_categories[] = {
    {"logStatusError", "refused calls and values, failed evaluations"},
    {"logStatusWarning", "things that work but are probably not meant"},
    {"logEvents", "mode changes and samples"},
};

/// Messages of one instance, each with its component and its name.
class Messages {
public:
    Messages(const char* component, const char* name, const Log& log);

    /// Reports and returns an error.
    Status error(const char* format, ...) ADCS_PRINTF_LIKE(2, 3);
    /// Of a pointer without which a function cannot do what it is asked for.
    Status null_pointer(const char* function) { return error("%s: a pointer is NULL", function); }
    Status set_debug_logging(bool on, std::size_t n, const char* const* categories);

protected:
    /// Something works but is probably not meant.
    void warning(const char* format, ...) ADCS_PRINTF_LIKE(2, 3);
    /// For who asks for the category.
    void event(const char* format, ...) ADCS_PRINTF_LIKE(2, 3);
    void message(Status status, const char* category, const char* format, std::va_list arguments);

private:
    const char* component_;
    char name_[128];
    Log log_;
    bool log_events_ = false;
};

}  // namespace adcs
