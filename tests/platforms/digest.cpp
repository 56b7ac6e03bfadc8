// Drives components with random legal values and prints, for each, a digest of every value it gave: on two platforms
// the same line, or they do not compute the same.
//
// digest                     all components
// digest NAME                one, with the bits of every value, and on stderr what was refused
// digest NAME BINARY         one, computed by the binary of its FMU
#include <cstdio>
#include <cstring>

#include "components.hpp"
#include "fmi/instance.hpp"
#include "fmi/token.hpp"
#include "legal_values.hpp"
#include "library.hpp"

const Component* selected = components;
adcs::Model* adcs::make_model() { return selected->make(); }

namespace {

using adcs::Causality, adcs::Role, adcs::Type, adcs::Variable;

constexpr int scenarios = 12, steps = 120, attempts = 8;

/// FNV-1a of the bits of numbers.
class Digest {
public:
    explicit Digest(bool verbose) : verbose_(verbose) {}
    void add(double x) {
        // one NaN for all: IEEE 754 leaves its sign to the processor
        const std::uint64_t bits = adcs::math::bits_of(x == x ? x : std::numeric_limits<double>::quiet_NaN());
        for (int byte = 0; byte < 8; ++byte) hash_ = (hash_ ^ (bits >> 8 * byte & 0xffU)) * 0x100000001b3U;
        ++count_;
        if (verbose_) std::printf(" %016llx", static_cast<unsigned long long>(bits));
    }
    void end_row(const char* what) const {
        if (verbose_) std::printf(" %s\n", what);
    }
    std::uint64_t value() const { return hash_; }
    int count() const { return count_; }

private:
    bool verbose_;
    std::uint64_t hash_ = 0xcbf29ce484222325U;
    int count_ = 0;
};

/// Why a scenario was not begun or did not come to its end.
void print(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String message, ...) {
    std::fprintf(stderr, "%s\n", message);
}
void ignore(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...) {}
fmi2CallbackFunctions callbacks = {ignore, std::calloc, std::free, nullptr, nullptr};

/// One instance in one scenario.
class Run {
public:
    Run(const Library& library, const adcs::Model& model, std::uint64_t scenario, std::uint64_t attempt, Digest& digest)
        : library_(library),
          table_(model.table()),
          digest_(digest),
          legal_(scenario, attempt),
          exchange_(scenario % 2 == 1),
          distance_(scenario % 3 == 0   ? 0.01
                    : scenario % 3 == 1 ? 0.3
                                        : 2.0),
          time_(scenario % 4 < 2 ? 0.0 : 1234.5),
          step_(scenario % 5 < 3 ? 0.05 : 0.013),
          changed_(attempt == 0             ? 1.0
                   : attempt < attempts - 1 ? 0.3
                                            : 0.0) {
        char token[40]{};
        adcs::make_token(model.name(), model.table(), token);
        instance_ = library_.instantiate(model.name(), exchange_ ? fmi2ModelExchange : fmi2CoSimulation, token, "",
                                         &callbacks, fmi2False, fmi2False);
        for (const Variable& v : table_) {
            if (v.type != Type::float64 || v.causality == Causality::independent) continue;
            for (std::uint32_t e = 0; e < v.size; ++e) readable_[n_readable_++] = v.vr + e;
        }
        for (const Variable& v : table_) n_states_ += v.role == Role::state ? v.size : 0;
    }
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;
    ~Run() { library_.free_instance(instance_); }

    /// Whether the component takes the parameters.
    bool start() {
        bool good = library_.setup(instance_, fmi2False, 0.0, time_, fmi2False, 0.0) == fmi2OK;
        for (const Variable& v : table_) {
            if (v.causality == Causality::parameter && legal_.between(0.0, 1.0) < changed_) {
                good = good && (v.type == Type::float64 ? set(v, legal_.parameter(v)) : set_integer(v));
            } else if (v.role == Role::state && changed_ > 0.0) {
                good = good && set(v, legal_.around(v, LegalValues::start(v), 0.1));
            }
        }
        return good && library_.enter_initialization(instance_) == fmi2OK && move_inputs() &&
               library_.exit_initialization(instance_) == fmi2OK;
    }

    /// Whether it went to its end.
    bool go() { return exchange_ ? exchange() : co_simulate(); }

private:
    bool co_simulate() {
        for (int k = 0; k < steps; ++k) {
            const double now = time_ + k * step_;
            if (!read() || library_.do_step(instance_, now, step_, fmi2True) != fmi2OK || !move_inputs()) return false;
        }
        return read();
    }

    /// Heun's method on the derivatives, with an event at every step.
    bool exchange() {
        if (!event()) return false;
        Values x(n_states_), start(n_states_), rate(n_states_), first(n_states_);
        for (int k = 0; k < steps; ++k) {
            if (!read() || !derivatives(start, first)) return false;
            for (std::size_t i = 0; i < x.size(); ++i) x[i] = start[i] + step_ * first[i];
            if (!move(time_ + (k + 1) * step_, x) || !derivatives(x, rate)) return false;
            for (std::size_t i = 0; i < x.size(); ++i) x[i] = start[i] + 0.5 * step_ * (first[i] + rate[i]);
            if (!move(time_ + (k + 1) * step_, x) || library_.enter_event_mode(instance_) != fmi2OK) return false;
            if (!move_inputs() || !event()) return false;
        }
        return read();
    }
    bool event() {
        fmi2EventInfo info{};
        return library_.new_discrete_states(instance_, &info) == fmi2OK &&
               library_.enter_continuous_time(instance_) == fmi2OK;
    }
    bool derivatives(Values& x, Values& rate) {
        return library_.get_states(instance_, x.data(), x.size()) == fmi2OK &&
               library_.get_derivatives(instance_, rate.data(), rate.size()) == fmi2OK;
    }
    bool move(double time, const Values& x) {
        return library_.set_time(instance_, time) == fmi2OK &&
               library_.set_states(instance_, x.data(), x.size()) == fmi2OK;
    }

    /// All values of the instance, into the digest.
    bool read() {
        Values values(n_readable_);
        if (library_.get(instance_, readable_, n_readable_, values.data()) != fmi2OK) return false;
        for (std::size_t i = 0; i < n_readable_; ++i) digest_.add(values[i]);
        digest_.end_row("");
        return true;
    }

    /// Every input wanders; now and then one goes back to where it started.
    bool move_inputs() {
        bool good = true;
        for (const Variable& v : table_) {
            if (v.causality != Causality::input || v.type != Type::float64) continue;
            const bool back = legal_.between(0.0, 1.0) < 0.05 || !moved_;
            const Values x = legal_.around(v, back ? LegalValues::start(v) : Values(&now_[v.vr], v.size), distance_);
            for (std::uint32_t e = 0; e < v.size; ++e) now_[v.vr + e] = x[e];
            good = good && set(v, x);
        }
        moved_ = true;
        return good;
    }

    bool set(const Variable& v, const Values& x) {
        fmi2ValueReference vrs[adcs::Table::scalar_capacity];
        for (std::uint32_t e = 0; e < v.size; ++e) vrs[e] = v.vr + e;
        return library_.set(instance_, vrs, v.size, x.data()) == fmi2OK;
    }
    bool set_integer(const Variable& v) {
        const double lowest = v.min > -100.0 ? v.min : -100.0, highest = v.max < 100.0 ? v.max : lowest + 4.0;
        const fmi2Integer value = legal_.integer(static_cast<int>(lowest), static_cast<int>(highest));
        return library_.set_integer(instance_, &v.vr, 1, &value) == fmi2OK;
    }

    const Library& library_;
    const adcs::Table& table_;
    Digest& digest_;
    LegalValues legal_;
    bool exchange_;
    double distance_, time_, step_;
    double changed_;  ///< the part of the parameters that are changed: some combinations a component refuses
    fmi2Component instance_;
    fmi2ValueReference readable_[adcs::Table::scalar_capacity];
    std::size_t n_readable_ = 0, n_states_ = 0;
    double now_[adcs::Table::scalar_capacity];  ///< the inputs, by their references
    bool moved_ = false;
};

/// "NAME digest values ended": how many values, and how many scenarios came to their end.
void drive(const Library& library, bool verbose) {
    adcs::Model* model = selected->make();
    model->reset();
    Digest digest(verbose);
    int ended = 0;
    for (std::uint64_t scenario = 0; scenario < scenarios; ++scenario) {
        for (std::uint64_t attempt = 0; attempt < attempts; ++attempt) {
            Run run(library, *model, scenario, attempt, digest);
            if (!run.start()) continue;
            const bool to_the_end = run.go();
            ended += to_the_end ? 1 : 0;
            digest.end_row(to_the_end ? "end" : "stopped");
            break;
        }
    }
    std::printf("%s %016llx %d %d\n", selected->name, static_cast<unsigned long long>(digest.value()), digest.count(),
                ended);
    model->~Model();
    std::free(model);
}

}  // namespace

int main(int argc, char** argv) {
    Library library;
    const bool all = argc < 2;
    if (!all) callbacks.logger = print;
    for (; selected->name != nullptr; ++selected) {
        if (!all && std::strcmp(selected->name, argv[1]) != 0) continue;
        if (argc > 2 && !library.load(argv[2])) {
            std::fprintf(stderr, "cannot load %s\n", argv[2]);
            return 1;
        }
        drive(library, !all);
        if (!all) return 0;
    }
    return all ? 0 : 2;
}
