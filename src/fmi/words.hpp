// What a law says in words: why its parameters make no sense together, what has happened to it.
#pragma once

#include <cstdarg>
#include <cstdio>

#include "fmi/compiler.hpp"

namespace adcs {

/// Said as printf does: say("fuel = %g is more than the tank holds", fuel). What was said first is kept.
class Words {
public:
    void operator()(const char* format, ...) ADCS_PRINTF_LIKE(2, 3) {
        if (text_[0] != '\0') return;
        std::va_list arguments;
        va_start(arguments, format);
        std::vsnprintf(text_, sizeof text_, format, arguments);
        va_end(arguments);
    }
    /// nullptr for nothing.
    const char* text() const { return text_[0] == '\0' ? nullptr : text_; }
    void clear() { text_[0] = '\0'; }

private:
    char text_[480] = "";
};

}  // namespace adcs
