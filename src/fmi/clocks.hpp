// When a component samples: its clocks, and which of their instants are to come.
#pragma once

#include <cmath>
#include <cstdint>

namespace adcs {

/// One sample, as sample() is told of it.
struct Sample {
    std::int64_t k;  ///< its index: it is that of the instant offset + k * period
    bool first;      ///< whether it is the first of the run
    int clock;       ///< by which of the component's clocks, in the order of their declaration
};

/// Instants offset + k * period, k = 0, 1, ...; period 0: none.
struct Clock {
    /// Of a period: how exactly a communication point must hit an instant.
    static constexpr double tolerance = 1e-9;

    double period = 0.0;
    double offset = 0.0;
    std::int64_t next = 0;   ///< index of the sample that is to come, or is being taken
    std::int64_t first = 0;  ///< index of the first one of the run

    bool runs() const { return period > 0.0; }
    double instant(std::int64_t k) const { return offset + static_cast<double>(k) * period; }
    /// Whether the next sample belongs to this time, or to an earlier one.
    bool is_due(double time) const { return runs() && instant(next) <= time + tolerance * period; }
    /// Whether it belongs to an earlier one than this.
    bool is_before(double time) const { return runs() && instant(next) < time - tolerance * period; }
    /// A run that starts between two instants takes the earlier one's sample at its start: nothing is held unset.
    void start(double time) {
        next = first = 0;
        if (!runs()) return;
        const double passed = (time - offset) / period;
        if (passed > 0.0) next = first = static_cast<std::int64_t>(std::floor(passed + tolerance));
    }
};

/// A period for what is sampled at the start alone: no run is so long that a second sample were due.
inline constexpr double once = 1e30;

/// All clocks of a component.
class Clocks {
public:
    static constexpr int capacity = 4;

    Clocks() = default;
    /// None of which runs.
    explicit Clocks(int count) : count_(count) {}
    void add(double period, double offset) { clocks_[count_++] = {period, offset}; }
    Clock* begin() { return clocks_; }
    Clock* end() { return clocks_ + count_; }
    const Clock* begin() const { return clocks_; }
    const Clock* end() const { return clocks_ + count_; }
    Clock& operator[](int i) { return clocks_[i]; }
    const Clock& operator[](int i) const { return clocks_[i]; }
    int count() const { return count_; }

    /// The clocks whose next sample is taken now, as bits.
    unsigned due() const { return due_; }
    void set_due(unsigned clocks) { due_ = clocks; }
    void look_at(double time) {
        due_ = 0;
        for (int i = 0; i < count_; ++i) due_ |= clocks_[i].is_due(time) ? 1U << i : 0U;
    }
    unsigned running() const {
        unsigned clocks = 0;
        for (int i = 0; i < count_; ++i) clocks |= clocks_[i].runs() ? 1U << i : 0U;
        return clocks;
    }

    /// action(sample) for each sample that is due.
    template <class Action>
    void each_due(const Action& action) const {
        for (int i = 0; i < count_; ++i) {
            const Clock& clock = clocks_[i];
            if ((due_ >> i & 1U) != 0) action(Sample{clock.next, clock.next == clock.first, i});
        }
    }
    /// The samples that were due have been taken for good.
    void advance() {
        for (int i = 0; i < count_; ++i) clocks_[i].next += due_ >> i & 1U;
        due_ = 0;
    }
    /// The earliest instant before a time, or that time.
    double earliest_before(double time) const {
        double earliest = time;
        for (const Clock& clock : *this) {
            if (clock.is_before(time)) earliest = std::fmin(earliest, clock.instant(clock.next));
        }
        return earliest;
    }
    /// The next instant after those that are due; infinite if no clock runs.
    double upcoming() const {
        double next = HUGE_VAL;
        for (int i = 0; i < count_; ++i) {
            const Clock& clock = clocks_[i];
            if (clock.runs()) next = std::fmin(next, clock.instant(clock.next + (due_ >> i & 1U)));
        }
        return next;
    }

private:
    Clock clocks_[capacity];
    int count_ = 0;
    unsigned due_ = 0;
};

/// Each clock at its k-th instant, which is the first of a run or not.
inline Clocks all_due(Clocks clocks, std::int64_t k, bool first) {
    for (Clock& clock : clocks) {
        clock.next = k;
        clock.first = first ? k : k - 1;
    }
    clocks.set_due((1U << clocks.count()) - 1U);
    return clocks;
}

}  // namespace adcs
