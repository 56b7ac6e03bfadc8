// Saving and restoring an instance. What is restored is checked first by its header and checksum, then, once loaded, for
// being a state that an instance can be in; what is not leaves the instance as it was.
#include "fmi/saved_state.hpp"

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "fmi/conditions.hpp"
#include "fmi/instance.hpp"
#include "fmi/values.hpp"

namespace adcs {
namespace {

/// Bytes of values after the header.
class Reader {
public:
    explicit Reader(const std::byte* at) : at_(at) {}
    double next() {
        double value;
        std::memcpy(&value, at_, sizeof value);
        at_ += sizeof value;
        return value;
    }

private:
    const std::byte* at_;
};

bool is_integer(double value) { return value >= -2147483648.0 && value <= 2147483647.0 && std::floor(value) == value; }

/// Whether a number can be one of a variable's values, as far as its type goes.
bool fits_type(const Variable& v, double value) {
    switch (v.type) {
        case Type::float64:
            return true;
        case Type::int32:
        case Type::enumeration:
            return is_integer(value);
        case Type::boolean:
            return value == 0.0 || value == 1.0;
        case Type::string:
            return value == 0.0;
    }
    return false;
}

bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

std::size_t Instance::state_size() const {
    return sizeof(SavedHeader) + (table().next_vr + n_held_ + (reacts() ? n_states_ : 0)) * sizeof(double);
}

void Instance::save(std::byte* bytes) const {
    SavedHeader header{};
    header.magic = SavedHeader::its_magic;
    header.version = SavedHeader::its_version;
    header.size = state_size();
    std::memcpy(header.token, token_, sizeof token_);
    header.time = time_;
    header.stop_time = stop_time_;
    header.settled_time = settled_time_;
    header.settled_signs = settled_signs_;
    header.signs = signs_;
    header.settled = settled_ ? 1 : 0;
    header.states_changed = states_changed_ ? 1 : 0;
    for (int i = 0; i < clocks_.count(); ++i) header.clocks[i] = clocks_[i];
    header.mode = mode_;
    header.interface = static_cast<std::uint8_t>(interface_);
    header.stop_defined = stop_defined_ ? 1 : 0;
    header.due = static_cast<std::uint8_t>(clocks_.due());
    header.outputs_fresh = outputs_fresh_ ? 1 : 0;
    header.derivatives_fresh = derivatives_fresh_ ? 1 : 0;
    header.parameters_checked = parameters_checked_ ? 1 : 0;
    header.inputs_checked = inputs_checked_ ? 1 : 0;
    std::byte* at = bytes + sizeof header;
    for (const Variable& v : table()) {
        for (std::uint32_t e = 0; e < v.size; ++e, at += sizeof(double)) {
            const double value = number_of<double>(v, e);
            std::memcpy(at, &value, sizeof value);
        }
    }
    std::memcpy(at, held_, n_held_ * sizeof(double));
    if (reacts()) std::memcpy(at + n_held_ * sizeof(double), settled_states_, n_states_ * sizeof(double));
    std::memcpy(bytes, &header, sizeof header);
    header.checksum = saved_checksum(bytes, state_size());
    std::memcpy(bytes, &header, sizeof header);
}

/// Takes over everything but texts; the bytes have the right size, and their integers are integers.
void Instance::load(const std::byte* bytes) {
    SavedHeader header;
    std::memcpy(&header, bytes, sizeof header);
    time_ = header.time;
    stop_time_ = header.stop_time;
    settled_time_ = header.settled_time;
    settled_signs_ = header.settled_signs;
    signs_ = header.signs;
    settled_ = header.settled != 0;
    states_changed_ = header.states_changed != 0;
    for (int i = 0; i < clocks_.count(); ++i) clocks_[i] = header.clocks[i];
    clocks_.set_due(header.due);
    note_what_holds();
    mode_ = static_cast<Mode>(header.mode);
    stop_defined_ = header.stop_defined != 0;
    outputs_fresh_ = header.outputs_fresh != 0;
    derivatives_fresh_ = header.derivatives_fresh != 0;
    parameters_checked_ = header.parameters_checked != 0;
    inputs_checked_ = header.inputs_checked != 0;
    Reader values(bytes + sizeof header);
    for (const Variable& v : table()) {
        for (std::uint32_t e = 0; e < v.size; ++e) set_number<double>(v, e, values.next());
    }
    bytes += sizeof header + table().next_vr * sizeof(double);
    std::memcpy(held_, bytes, n_held_ * sizeof(double));
    if (reacts()) std::memcpy(settled_states_, bytes + n_held_ * sizeof(double), n_states_ * sizeof(double));
}

/// Whether bytes are a state of this kind of component, undamaged, and can be loaded.
Status Instance::check_saved(const char* function, const void* bytes, std::size_t size) {
    SavedHeader header;
    if (bytes == nullptr) return null_pointer(function);
    std::memcpy(&header.magic, bytes, sizeof header.magic);  // nothing else is looked at of what is not a saved state
    if (header.magic != SavedHeader::its_magic) return error("%s: this is not a saved state", function);
    std::memcpy(&header.version, static_cast<const std::byte*>(bytes) + offsetof(SavedHeader, version),
                sizeof header.version);
    if (header.version != SavedHeader::its_version) {
        return error("%s: the saved state has format %u, expected %u: it comes from another version of this FMU",
                     function, header.version, SavedHeader::its_version);
    }
    std::memcpy(&header, bytes, sizeof header);
    if (header.size != size) {
        return error("%s: the saved state says that it has %llu bytes, expected %zu", function,
                     static_cast<unsigned long long>(header.size), size);
    }
    if (header.checksum != saved_checksum(static_cast<const std::byte*>(bytes), size)) {
        return error("%s: the saved state is damaged, its checksum does not fit", function);
    }
    if (std::memcmp(header.token, token_, sizeof token_) != 0 ||
        header.interface != static_cast<std::uint8_t>(interface_)) {
        return error("%s: the saved state is not from this kind of component", function);
    }
    const unsigned own_modes =
        interface_ == Interface::co_simulation ? unsigned{mode_step} : unsigned{mode_event | mode_continuous};
    const unsigned modes = mode_instantiated | mode_initialization | mode_terminated | own_modes;
    const bool one_mode = header.mode != 0 && (header.mode & (header.mode - 1)) == 0;
    if (!one_mode || (header.mode & modes) == 0) {
        return error("%s: the saved state has no mode of this interface: %u", function, header.mode);
    }
    for (const std::uint8_t flag :
         {header.stop_defined, header.outputs_fresh, header.derivatives_fresh, header.parameters_checked,
          header.inputs_checked, header.settled, header.states_changed}) {
        if (flag > 1) return error("%s: the saved state has a flag that is neither 0 nor 1", function);
    }
    if (((header.settled_signs | header.signs) & ~event_bits()) != 0 || (!reacts() && header.states_changed != 0)) {
        return error("%s: the saved state has events of no event function", function);
    }
    if (header.due >> table().clocks != 0) return error("%s: the saved state has samples of no clock", function);
    Reader values(static_cast<const std::byte*>(bytes) + sizeof header);
    for (const Variable& v : table()) {
        for (std::uint32_t e = 0; e < v.size; ++e) {
            const double value = values.next();
            if (!fits_type(v, value)) {
                return error("%s: %s = %g in the saved state, but %s is expected", function, v.name, value,
                             v.type == Type::boolean  ? "0 or 1"
                             : v.type == Type::string ? "0"
                                                      : "an integer");
            }
        }
    }
    for (const Variable& v : table()) {  // those before a pending sample
        for (std::uint32_t e = 0; is_held(v) && e < v.size; ++e) {
            const double value = values.next();
            if (!fits_type(v, value) || (v.type == Type::enumeration && !is_item(v, value)))
                return error("%s: a held value of the saved state is %g", function, value);
        }
    }
    return Status::ok;
}

/// Whether an instance can be in the state just loaded.
Status Instance::check_loaded(const char* function) {
    if (!std::isfinite(time_) || (stop_defined_ && std::isnan(stop_time_)) || !same(*clock_time_, time_)) {
        return error("%s: the saved state has the times %g, %g and %g", function, time_, *clock_time_, stop_time_);
    }
    for (const Variable& v : table()) {
        const bool settable = v.causality == Causality::parameter || v.causality == Causality::input;
        const bool computed =
            (v.causality == Causality::output && outputs_fresh_) || (v.role == Role::derivative && derivatives_fresh_);
        if (!settable && !computed && v.role != Role::state && !is_held(v)) continue;
        for (std::uint32_t e = 0; e < v.size; ++e) {
            const double value = number_of<double>(v, e);
            const bool in_bounds = !settable || (value > v.above && value >= v.min && value <= v.max);
            const bool is_listed = v.type != Type::enumeration || is_item(v, value);
            if (std::isfinite(value) && in_bounds && is_listed) continue;
            char name[128];
            element_name(v, e, name, sizeof name);
            return error("%s: %s = %g in the saved state", function, name, value);
        }
        const bool checked = v.causality == Causality::input ? inputs_checked_ : parameters_checked_ && settable;
        char fault[320];
        if (checked && !meets_condition(v, fault, sizeof fault)) return error("%s: %s", function, fault);
    }
    for (std::size_t i = 0; i < n_held_; ++i) {
        if (!std::isfinite(held_[i])) return error("%s: a held value of the saved state is %g", function, held_[i]);
    }
    for (std::size_t i = 0; states_changed_ && i < n_states_; ++i) {
        if (!std::isfinite(settled_states_[i]))
            return error("%s: a state before an event of the saved state is %g", function, settled_states_[i]);
    }
    if (!std::isfinite(settled_time_) || (settled_ && settled_time_ > time_)) {
        return error("%s: the latest event of the saved state was at t = %g", function, settled_time_);
    }
    if (parameters_checked_) {
        Words fault;
        model_->validate(fault);
        if (fault.text() != nullptr) return error("%s: %s", function, fault.text());
    }

    const bool running = (mode_ & (mode_instantiated | mode_initialization)) == 0;
    const Clocks expected = running || parameters_checked_ ? model_->clocks() : clocks_;
    for (int i = 0; i < clocks_.count(); ++i) {
        const Clock& clock = clocks_[i];
        if (fits(clock, expected[i], (clocks_.due() >> i & 1U) != 0)) continue;
        return error("%s: the clock of the saved state does not fit: sample %lld at t = %g, period %g s", function,
                     static_cast<long long>(clock.next), time_, clock.period);
    }
    return Status::ok;
}

/// Whether a clock belongs to the parameters, which say what is expected, and its next sample to the time.
bool Instance::fits(const Clock& clock, const Clock& expected, bool due) const {
    if (!same(clock.period, expected.period) || !same(clock.offset, expected.offset)) return false;
    if (!std::isfinite(clock.period) || !std::isfinite(clock.offset) || clock.period < 0.0) return false;
    if (clock.first < 0 || clock.next < clock.first) return false;
    if (!clock.runs()) return clock.next == 0 && !due;
    if (clock.next > 9007199254740992) return false;  // 2^53, beyond which its instant is not exact
    if (mode_ != mode_step) return true;
    const double some = 1e-6 + 1e-15 * std::fabs(time_) / clock.period;  // of a period; late times are rounded more
    const double ahead = (clock.instant(clock.next) - time_) / clock.period;
    return ahead > -1.0 - some && (ahead < 1.0 + some || clock.next == 0) && due == clock.is_due(time_);
}

Status Instance::restore(const char* function, const void* state) {
    if (Status status = check_saved(function, state, state_size()); status != Status::ok) return status;
    save(backup_);
    load(static_cast<const std::byte*>(state));
    const Status status = check_loaded(function);
    if (status != Status::ok) load(backup_);
    // a text is no number that could be saved: the outputs, which are what they were, bring it back
    if (status == Status::ok && outputs_fresh_ && has_texts_) model_->outputs(holding());
    return status;
}

Status Instance::save_new(const char* function, void** state) {
    if (state == nullptr) return null_pointer(function);
    if (*state != nullptr) {  // to be overwritten
        if (Status status = check_saved(function, *state, state_size()); status != Status::ok) return status;
    } else {
        *state = std::malloc(state_size());
        if (*state == nullptr) return error("%s: no memory for a saved state", function);
    }
    save(static_cast<std::byte*>(*state));
    return Status::ok;
}

Status Instance::serialize(const char* function, const void* state, void* bytes, std::size_t size) {
    if (bytes == nullptr) return null_pointer(function);
    if (size < state_size()) return error("%s: %zu bytes given, %zu expected", function, size, state_size());
    if (Status status = check_saved(function, state, state_size()); status != Status::ok) return status;
    std::memcpy(bytes, state, state_size());
    return Status::ok;
}

Status Instance::deserialize(const char* function, const void* bytes, std::size_t size, void** state) {
    if (bytes == nullptr || state == nullptr) return null_pointer(function);
    if (size != state_size()) return error("%s: %zu bytes given, %zu expected", function, size, state_size());
    if (Status status = check_saved(function, bytes, size); status != Status::ok) return status;
    if (*state != nullptr) {
        if (Status status = check_saved(function, *state, size); status != Status::ok) return status;
    } else {
        *state = std::malloc(size);
        if (*state == nullptr) return error("%s: no memory for a saved state", function);
    }
    std::memcpy(*state, bytes, size);
    return Status::ok;
}

void Instance::free_state(void** state) {
    if (state == nullptr || *state == nullptr) return;
    *static_cast<volatile std::uint32_t*>(*state) = 0;  // its magic number
    std::free(*state);
    *state = nullptr;
}

}  // namespace adcs
