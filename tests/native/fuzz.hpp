// What the two fuzzers share: random numbers, one instance of FMI 2 or FMI 3 behind the same calls, values that fit or do
// not, and how a failure is reported. Everything follows from a seed, which a failure names.
#pragma once

#include <signal.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "fmi/instance.hpp"
#include "fmi/token.hpp"
#include "fmi2Functions.h"
#include "fmi3Functions.h"

namespace fuzz {

using adcs::Causality;
using adcs::Role;
using adcs::Type;
using adcs::Variable;

/// splitmix64.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t next() {
        std::uint64_t z = state_ += 0x9e3779b97f4a7c15U;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
        return z ^ (z >> 31);
    }
    std::size_t below(std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(next() % n); }
    double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
    bool chance(double p) { return uniform() < p; }
    template <class T, std::size_t N>
    T pick(const T (&items)[N]) {
        return items[below(N)];
    }

private:
    std::uint64_t state_;
};

inline double special(Random& random) {
    static constexpr double values[] = {NAN,   INFINITY, -INFINITY, 0.0,  -0.0, 1e300, -1e300, 5e-324, 1e-300,
                                        1e-18, 9.3e18,   -1.0,      1e19, 1e20, 2.1e9, 1e9,    1e-12,  0.5};
    return random.pick(values);
}

/// The one run that this process does, for the line that it prints and for the handler of the clock.
struct Report {
    const char* component = "";
    std::uint64_t seed = 0;
    std::string last_message;
};
inline Report report;

[[noreturn]] inline void fail(const char* what) {
    std::printf("%s: seed %llu: %s (last message: %s)\n", report.component,
                static_cast<unsigned long long>(report.seed), what, report.last_message.c_str());
    std::fflush(stdout);
    std::abort();  // so that a debugger, or the sanitizer, shows where
}

inline void require(bool good, const char* what) {
    if (!good) fail(what);
}

/// A call that has not come back after so many seconds is taken for one that never will.
inline void watch(unsigned seconds) {
    signal(SIGALRM, [](int) {
        constexpr char text[] = "a call does not come back\n";
        if (write(1, text, sizeof text - 1) < 0) _exit(2);
        std::abort();
    });
    alarm(seconds);
}

inline void log2(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String message, ...) {
    report.last_message = message;
}
inline void log3(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String message) { report.last_message = message; }

/// An instance of either version and interface. Statuses are those of both standards: 0 OK, 3 error.
class Tool {
public:
    Tool(int version, bool cosim, const char* token) : version_(version), cosim_(cosim) {
        static const fmi2CallbackFunctions callbacks{log2, std::calloc, std::free, nullptr, nullptr};
        if (version == 2) {
            handle_ = fmi2Instantiate("it", cosim ? fmi2CoSimulation : fmi2ModelExchange, token, "", &callbacks, 0, 0);
        } else if (cosim) {
            handle_ = fmi3InstantiateCoSimulation("it", token, "", false, false, false, false, nullptr, 0, nullptr,
                                                  log3, nullptr);
        } else {
            handle_ = fmi3InstantiateModelExchange("it", token, "", false, false, nullptr, log3);
        }
        require(handle_ != nullptr, "instantiate");
    }
    ~Tool() { version_ == 2 ? fmi2FreeInstance(handle_) : fmi3FreeInstance(handle_); }
    Tool(const Tool&) = delete;
    Tool& operator=(const Tool&) = delete;

    int version() const { return version_; }
    bool cosim() const { return cosim_; }
    void* handle() const { return handle_; }

    int get(const Variable& v, double* values) {
        if (version_ == 3) return fmi3GetFloat64(handle_, &v.vr, 1, values, v.size);
        const auto vrs = scalars(v);
        return fmi2GetReal(handle_, vrs.data(), vrs.size(), values);
    }
    /// Of a Boolean, integer or enumeration.
    int get(const Variable& v, std::int32_t* value) {
        if (v.type == Type::boolean) {
            if (version_ == 2) return fmi2GetBoolean(handle_, &v.vr, 1, value);
            bool on = false;
            const int status = fmi3GetBoolean(handle_, &v.vr, 1, &on, 1);
            *value = on ? 1 : 0;
            return status;
        }
        if (version_ == 2) return fmi2GetInteger(handle_, &v.vr, 1, value);
        if (v.type == Type::int32) return fmi3GetInt32(handle_, &v.vr, 1, value, 1);
        std::int64_t item = 0;
        const int status = fmi3GetInt64(handle_, &v.vr, 1, &item, 1);
        *value = static_cast<std::int32_t>(item);
        return status;
    }
    int get(const Variable& v, const char** text) {
        if (version_ == 3) return fmi3GetString(handle_, &v.vr, 1, text, 1);
        return fmi2GetString(handle_, &v.vr, 1, text);
    }
    int set(const Variable& v, const double* values) {
        if (version_ == 3) return fmi3SetFloat64(handle_, &v.vr, 1, values, v.size);
        const auto vrs = scalars(v);
        return fmi2SetReal(handle_, vrs.data(), vrs.size(), values);
    }
    int set(const Variable& v, const std::int32_t* value) {
        if (v.type == Type::string) {
            const char* text = "no";
            if (version_ == 3) return fmi3SetString(handle_, &v.vr, 1, &text, 1);
            return fmi2SetString(handle_, &v.vr, 1, &text);
        }
        if (v.type == Type::boolean) {
            if (version_ == 2) return fmi2SetBoolean(handle_, &v.vr, 1, value);
            const bool on = *value != 0;
            return fmi3SetBoolean(handle_, &v.vr, 1, &on, 1);
        }
        if (version_ == 2) return fmi2SetInteger(handle_, &v.vr, 1, value);
        if (v.type == Type::int32) return fmi3SetInt32(handle_, &v.vr, 1, value, 1);
        const std::int64_t item = *value;
        return fmi3SetInt64(handle_, &v.vr, 1, &item, 1);
    }
    int enter(double start, bool stop_defined, double stop) {
        if (version_ == 3) return fmi3EnterInitializationMode(handle_, false, 0.0, start, stop_defined, stop);
        const int status = fmi2SetupExperiment(handle_, 0, 0.0, start, stop_defined ? 1 : 0, stop);
        return status != 0 ? status : fmi2EnterInitializationMode(handle_);
    }
    int exit_initialization() {
        return version_ == 2 ? int{fmi2ExitInitializationMode(handle_)} : int{fmi3ExitInitializationMode(handle_)};
    }
    int terminate() { return version_ == 2 ? int{fmi2Terminate(handle_)} : int{fmi3Terminate(handle_)}; }
    int reset() { return version_ == 2 ? int{fmi2Reset(handle_)} : int{fmi3Reset(handle_)}; }
    int step(double time, double size) {
        if (version_ == 2) return fmi2DoStep(handle_, time, size, 1);
        bool event = false, terminate = false, early = false;
        double reached = 0.0;
        const int status = fmi3DoStep(handle_, time, size, true, &event, &terminate, &early, &reached);
        return status;
    }
    int set_time(double t) { return version_ == 2 ? int{fmi2SetTime(handle_, t)} : int{fmi3SetTime(handle_, t)}; }
    int set_states(const double* x, std::size_t n) {
        return version_ == 2 ? int{fmi2SetContinuousStates(handle_, x, n)}
                             : int{fmi3SetContinuousStates(handle_, x, n)};
    }
    int get_states(double* x, std::size_t n) {
        return version_ == 2 ? int{fmi2GetContinuousStates(handle_, x, n)}
                             : int{fmi3GetContinuousStates(handle_, x, n)};
    }
    int derivatives(double* x, std::size_t n) {
        return version_ == 2 ? int{fmi2GetDerivatives(handle_, x, n)}
                             : int{fmi3GetContinuousStateDerivatives(handle_, x, n)};
    }
    int enter_event() { return version_ == 2 ? int{fmi2EnterEventMode(handle_)} : int{fmi3EnterEventMode(handle_)}; }
    int enter_continuous() {
        return version_ == 2 ? int{fmi2EnterContinuousTimeMode(handle_)} : int{fmi3EnterContinuousTimeMode(handle_)};
    }
    int update() {
        if (version_ == 2) {
            fmi2EventInfo info;
            return fmi2NewDiscreteStates(handle_, &info);
        }
        bool a = false, b = false, c = false, d = false, e = false;
        double next = 0.0;
        return fmi3UpdateDiscreteStates(handle_, &a, &b, &c, &d, &e, &next);
    }
    int save(void** state) {
        return version_ == 2 ? int{fmi2GetFMUstate(handle_, state)} : int{fmi3GetFMUState(handle_, state)};
    }
    int restore(void* state) {
        return version_ == 2 ? int{fmi2SetFMUstate(handle_, state)} : int{fmi3SetFMUState(handle_, state)};
    }
    void free_state(void** state) {
        if (version_ == 2) {
            fmi2FreeFMUstate(handle_, state);
        } else {
            fmi3FreeFMUState(handle_, state);
        }
    }
    int to_bytes(void* state, std::vector<unsigned char>& bytes) {
        std::size_t size = 0;
        int status = version_ == 2 ? int{fmi2SerializedFMUstateSize(handle_, state, &size)}
                                   : int{fmi3SerializedFMUStateSize(handle_, state, &size)};
        if (status != 0) return status;
        bytes.resize(size);
        return version_ == 2
                   ? int{fmi2SerializeFMUstate(handle_, state, reinterpret_cast<fmi2Byte*>(bytes.data()), size)}
                   : int{fmi3SerializeFMUState(handle_, state, bytes.data(), size)};
    }
    int from_bytes(const std::vector<unsigned char>& bytes, void** state) {
        return version_ == 2 ? int{fmi2DeSerializeFMUstate(handle_, reinterpret_cast<const fmi2Byte*>(bytes.data()),
                                                           bytes.size(), state)}
                             : int{fmi3DeserializeFMUState(handle_, bytes.data(), bytes.size(), state)};
    }

private:
    static std::vector<std::uint32_t> scalars(const Variable& v) {
        std::vector<std::uint32_t> vrs(v.size);
        for (std::uint32_t i = 0; i < v.size; ++i) vrs[i] = v.vr + i;
        return vrs;
    }

    int version_;
    bool cosim_;
    void* handle_ = nullptr;
};

/// The component of this program, its start values, and values near them.
class Subject {
public:
    Subject() : model_(adcs::make_model()) {
        model_->reset();
        adcs::make_token(model_->name(), table(), token_);
        report.component = model_->name();
        for (const Variable& v : table()) n_states_ += v.role == Role::state ? v.size : 0;
    }
    const adcs::Table& table() const { return model_->table(); }
    const char* token() const { return token_; }
    std::size_t states() const { return n_states_; }
    const Variable& any(Random& random) const {
        return table().variables[random.below(static_cast<std::size_t>(table().count))];
    }

    /// A value near the start value, seldom anything. Times and bounds get no small values, with which a legal step
    /// takes minutes.
    double value(Random& random, const Variable& v, std::uint32_t e, double wild) const {
        if (random.chance(wild)) return special(random);
        const double start = static_cast<const double*>(v.data)[e];
        if (v.causality == Causality::parameter && v.unit == &adcs::unit::s) {
            return start * (1.0 + random.uniform());
        }
        if (v.kind != adcs::Kind::any) return start * (1.0 + 1e-3 * random.uniform());
        return start + 0.02 * (random.uniform() - 0.5) * (1.0 + std::fabs(start));
    }
    int set_any(Random& random, Tool& tool, double wild) const {
        const Variable& v = any(random);
        if (v.type != Type::float64) {
            const std::int32_t value = static_cast<std::int32_t>(random.below(4)) - 1;
            return tool.set(v, &value);
        }
        std::vector<double> values(v.size);
        for (std::uint32_t e = 0; e < v.size; ++e) values[e] = value(random, v, e, wild);
        return tool.set(v, values.data());
    }
    /// Every value that can be read, and the status of reading it.
    std::vector<std::pair<int, std::vector<double>>> all(Tool& tool) const {
        std::vector<std::pair<int, std::vector<double>>> read;
        for (const Variable& v : table()) {
            std::vector<double> values(v.size);
            std::int32_t integer = 0;
            const char* text = "";
            const int status = v.type == Type::float64  ? tool.get(v, values.data())
                               : v.type == Type::string ? tool.get(v, &text)
                                                        : tool.get(v, &integer);
            for (; *text != '\0'; ++text) integer = 31 * integer % 65536 + *text;
            if (v.type != Type::float64) values[0] = integer;
            for (const double x : values) require(status > 1 || std::isfinite(x), "a value is not finite, but OK");
            read.emplace_back(status, std::move(values));
        }
        return read;
    }

private:
    struct Destroy {  // made in memory from malloc
        void operator()(adcs::Model* model) const {
            model->~Model();
            std::free(model);
        }
    };
    std::unique_ptr<adcs::Model, Destroy> model_;
    char token_[40]{};
    std::size_t n_states_ = 0;
};

inline bool same(const std::vector<std::pair<int, std::vector<double>>>& a,
                 const std::vector<std::pair<int, std::vector<double>>>& b) {
    for (std::size_t i = 0; i < a.size(); ++i) {
        if ((a[i].first > 1) != (b[i].first > 1)) return false;
        if (a[i].first > 1) continue;
        if (std::memcmp(a[i].second.data(), b[i].second.data(), a[i].second.size() * sizeof(double)) != 0) return false;
    }
    return a.size() == b.size();
}

}  // namespace fuzz
