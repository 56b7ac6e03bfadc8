#include "fmi/messages.hpp"

#include <cstdio>
#include <cstring>

namespace adcs {

Messages::Messages(const char* component, const char* name, const Log& log) : component_(component), log_(log) {
    std::snprintf(name_, sizeof name_, "%s", name);
}

void Messages::message(Status status, const char* category, const char* format, std::va_list arguments) {
    if (log_.write == nullptr) return;
    char text[768];
    const int start = std::snprintf(text, sizeof text, "%s '%s': ", component_, name_);
    std::vsnprintf(text + start, sizeof text - static_cast<std::size_t>(start), format, arguments);
    for (char* c = text; *c != '\0'; ++c) {
        if (*c == '%' || *c == '#') *c = ' ';  // FMI 2 loggers read these as directives
    }
    log_.write(log_.context, status, category, text);
}

Status Messages::error(const char* format, ...) {
    std::va_list arguments;
    va_start(arguments, format);
    message(Status::error, log_categories[0].name, format, arguments);
    va_end(arguments);
    return Status::error;
}

void Messages::event(const char* format, ...) {
    if (!log_events_) return;
    std::va_list arguments;
    va_start(arguments, format);
    message(Status::ok, log_categories[2].name, format, arguments);
    va_end(arguments);
}

void Messages::warning(const char* format, ...) {
    std::va_list arguments;
    va_start(arguments, format);
    message(Status::warning, log_categories[1].name, format, arguments);
    va_end(arguments);
}

Status Messages::set_debug_logging(bool on, std::size_t n, const char* const* categories) {
    if (n != 0 && categories == nullptr) return null_pointer("set debug logging");
    bool events = n == 0;
    for (std::size_t i = 0; i < n; ++i) {
        if (categories[i] == nullptr) return null_pointer("set debug logging");
        bool known = false;
        for (const LogCategory& c : log_categories) known = known || std::strcmp(categories[i], c.name) == 0;
        if (!known) return error("log category '%.60s' is not known", categories[i]);
        events = events || std::strcmp(categories[i], log_categories[2].name) == 0;
    }
    if (events) log_events_ = on;
    return Status::ok;
}

}  // namespace adcs
