// The layout of a saved state: this header, the value of every variable as a double in the order of the table, the values
// held before a pending sample or event, and the states before it if there are events. Little-endian, like every platform that FMUs are made for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "fmi/declaration.hpp"

namespace adcs {

struct SavedHeader {
    static constexpr std::uint32_t its_magic = 0x53434441;  // "ADCS"
    static constexpr std::uint32_t its_version = 3;

    std::uint32_t magic, version;
    std::uint64_t checksum;  ///< over all that follows it
    std::uint64_t size;      ///< of the whole, in bytes
    char token[40];          ///< of the component's declaration
    double time, stop_time, settled_time;
    Clock clocks[Clocks::capacity];
    std::uint32_t mode, settled_signs, signs;
    std::uint8_t interface, stop_defined, due, outputs_fresh, derivatives_fresh, parameters_checked, inputs_checked;
    std::uint8_t settled, states_changed;
    std::uint8_t unused[3];  ///< 0, to a multiple of eight bytes
};
static_assert(sizeof(SavedHeader) % sizeof(double) == 0);

/// FNV-1a over words of eight bytes, each mixed downwards so that no two flips of bits cancel.
inline std::uint64_t checksum(const std::byte* bytes, std::size_t size) {
    std::uint64_t sum = 0xcbf29ce484222325U;
    for (std::size_t at = 0; at + sizeof sum <= size; at += sizeof sum) {
        std::uint64_t word;
        std::memcpy(&word, bytes + at, sizeof word);
        sum = (sum ^ word) * 0x100000001b3U;
        sum ^= sum >> 32;
    }
    return sum;
}

/// Of a whole saved state, as the header should say it.
inline std::uint64_t saved_checksum(const std::byte* state, std::size_t size) {
    constexpr std::size_t from = offsetof(SavedHeader, size);
    return checksum(state + from, size - from);
}

}  // namespace adcs
