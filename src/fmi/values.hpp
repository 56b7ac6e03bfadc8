// One element of a variable as a number, whatever its type is.
#pragma once

#include <cstdio>

#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

/// Of a component of scalar type T: a Boolean is 0 or 1, an enumeration the number of its item, a text is 0.
template <class T>
double number_of(const Variable& v, std::uint32_t e) {
    switch (v.type) {
        case Type::float64:
            return value_of(static_cast<const T*>(v.data)[e]);
        case Type::int32:
        case Type::enumeration:
            return static_cast<const std::int32_t*>(v.data)[e];
        case Type::boolean:
            return static_cast<const bool*>(v.data)[e] ? 1.0 : 0.0;
        case Type::string:
            break;
    }
    return 0.0;
}

/// The number has to be one that the type has; a text stays as it is.
template <class T>
void set_number(const Variable& v, std::uint32_t e, double number) {
    switch (v.type) {
        case Type::float64:
            static_cast<T*>(v.data)[e] = T(number);
            return;
        case Type::int32:
        case Type::enumeration:
            static_cast<std::int32_t*>(v.data)[e] = static_cast<std::int32_t>(number);
            return;
        case Type::boolean:
            static_cast<bool*>(v.data)[e] = number != 0.0;
            return;
        case Type::string:
            return;
    }
}

/// Whether a number is one of the items of an enumeration.
inline bool is_item(const Variable& v, double number) {
    return number >= 0.0 && number < v.n_items && static_cast<std::uint32_t>(number) == number;
}

/// "0 (off), 1 (on)" of an enumeration, as far as there is room.
inline void list_items(const Variable& v, char* text, std::size_t size) {
    std::size_t used = 0;
    *text = '\0';
    for (std::uint32_t i = 0; i < v.n_items && used < size; ++i) {
        const int n = std::snprintf(text + used, size - used, "%s%u (%s)", i == 0 ? "" : ", ", i, v.items[i]);
        used += static_cast<std::size_t>(n);
    }
}

}  // namespace adcs
