// The identity of a component's declaration, by which a binary knows its own modelDescription.xml.
#pragma once

#include <cstdint>
#include <cstdio>

#include "fmi/unit_of.hpp"

namespace adcs {
namespace detail {

class Hash {  // FNV-1a, 64 bit
public:
    explicit Hash(std::uint64_t basis) : value_(basis) {}
    void add(const char* text) {
        do byte(static_cast<unsigned char>(*text));
        while (*text++ != '\0');
    }
    void add(std::uint32_t number) {
        for (int shift = 0; shift < 32; shift += 8) byte(static_cast<unsigned char>(number >> shift));
    }
    std::uint64_t value() const { return value_; }

private:
    void byte(unsigned char b) { value_ = (value_ ^ b) * 0x100000001b3U; }
    std::uint64_t value_;
};

}  // namespace detail

/// Changes whenever names, types, items, shapes or references do.
inline void make_token(const char* name, const Table& table, char (&token)[40]) {
    detail::Hash a(0xcbf29ce484222325U), b(0x9ae16a3b2f90404fU);
    for (detail::Hash* hash : {&a, &b}) {
        hash->add(name);
        for (const Variable& v : table) {
            hash->add(v.name);
            hash->add(UnitOf(v)->name);
            for (const std::uint32_t number :
                 {v.vr, v.rows, v.cols, static_cast<std::uint32_t>(v.type), static_cast<std::uint32_t>(v.causality),
                  static_cast<std::uint32_t>(v.variability), static_cast<std::uint32_t>(v.role)}) {
                hash->add(number);
            }
            for (std::uint32_t i = 0; i < v.n_items; ++i) hash->add(v.items[i]);
        }
    }
    std::snprintf(token, sizeof token, "{%08x-%04x-%04x-%04x-%04x%08x}", static_cast<unsigned>(a.value() >> 32),
                  static_cast<unsigned>(a.value() >> 16) & 0xffffU, static_cast<unsigned>(a.value()) & 0xffffU,
                  static_cast<unsigned>(b.value() >> 48), static_cast<unsigned>(b.value() >> 32) & 0xffffU,
                  static_cast<unsigned>(b.value()));
}

}  // namespace adcs
