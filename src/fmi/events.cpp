// Events of an instance: what happens where event functions change their signs, at times that were set, at samples, and
// at the start.
#include <cmath>

#include "fmi/instance.hpp"

namespace adcs {
namespace {

/// After so many rounds at one time it is taken for granted that there is no end.
constexpr int most_rounds = 100;

}  // namespace

/// Which event functions are positive, as bits.
unsigned Instance::signs() const {
    unsigned positive = 0;
    for (std::size_t i = 0; i < n_events_; ++i) positive |= *events_[i] > 0.0 ? 1U << i : 0U;
    return positive;
}

/// The earliest time after this one at which something is meant to happen; infinite if there is none.
double Instance::next_wake(double time) const {
    double next = HUGE_VAL;
    for (std::size_t i = 0; i < n_wakes_; ++i) {
        if (*wakes_[i] > time && *wakes_[i] < never) next = std::fmin(next, *wakes_[i]);
    }
    return next;
}

/// Whether events() is to be called in the first round: outputs belong to the present time.
bool Instance::is_due(const Events& e) const {
    return e.crossed != 0 || e.first || at_sample() || next_wake(settled_time_) <= time_;
}

/// events(), until nothing changes its sign any more.
Status Instance::react() {
    signs_ = signs();
    Events e{settled_ ? signs_ ^ settled_signs_ : 0U, !settled_};
    if (!is_due(e)) return Status::ok;
    read_states(settled_states_);
    for (int round = 0; round < most_rounds; ++round) {
        event("event at t = %g", time_);
        model_->events(e);
        normalise_states();
        states_changed_ = false;
        for (std::size_t i = 0; i < n_states_; ++i)
            states_changed_ = states_changed_ || *states_[i].x != settled_states_[i];
        if (Status status = finite_held(); status != Status::ok) return status;
        if (Status status = finite_states(", set by events()"); status != Status::ok) return status;
        model_->outputs(holding());
        if (Status status = finite_outputs(); status != Status::ok) return status;
        const unsigned before = signs_;
        signs_ = signs();
        e = {signs_ ^ before, false};
        if (e.crossed == 0) return Status::ok;
    }
    return error("at t = %g: events() comes to no end: event functions change their signs with what it sets", time_);
}

/// After an internal step: whether an event function has changed its sign in it. Then time and states are those right
/// after the earliest change.
Status Instance::locate(double begin, double h, bool& crossed) {
    const auto has_crossed = [this](double time) {
        move_to(time);
        model_->outputs(sampling_);
        return signs() != settled_signs_;
    };
    crossed = has_crossed(begin + h);
    if (!crossed) return finite_outputs();
    double before = 0.0, after = h;  // of the change, until no number lies between them
    for (;;) {
        const double middle = before + 0.5 * (after - before);
        if (!(begin + before < begin + middle && begin + middle < begin + after)) break;
        write_states(before_);
        if (Status status = step_within(begin, middle); status != Status::ok) return status;
        (has_crossed(begin + middle) ? after : before) = middle;
    }
    write_states(before_);
    if (Status status = step_within(begin, after); status != Status::ok) return status;
    move_to(begin + after);
    return Status::ok;
}

}  // namespace adcs
