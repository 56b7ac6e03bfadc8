#include "fmi/instance.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include "fmi/conditions.hpp"
#include "fmi/token.hpp"
#include "fmi/values.hpp"

namespace adcs {
namespace {

/// The Runge-Kutta method turns a quaternion by slightly too little, in radians per second; above this a spin is reported.
constexpr double spin_error_bound = 1.7453292519943296e-4;  // 0.01 deg/s

double* floats(const Variable& v) { return static_cast<double*>(v.data); }
bool all_finite(const double* values, std::size_t n) {
    double zero = 0.0;
    for (std::size_t i = 0; i < n; ++i) zero += 0.0 * values[i];
    return zero == 0.0;
}

template <class Value>
double as_number(Value value) {
    return static_cast<double>(value);
}
double as_number(const char* /*text*/) { return 0.0; }  // none is ever set

template <class Value, class Stored>
Value as_passed(Stored stored) {
    return static_cast<Value>(stored);
}
template <>
const char* as_passed(const char* text) {
    return text != nullptr ? text : "";
}

/// "0 (off), 1 (on)" of an enumeration, as far as there is room.
void list_items(const Variable& v, char* text, std::size_t size) {
    std::size_t used = 0;
    *text = '\0';
    for (std::uint32_t i = 0; i < v.n_items && used < size; ++i) {
        const int n = std::snprintf(text + used, size - used, "%s%u (%s)", i == 0 ? "" : ", ", i, v.items[i]);
        used += static_cast<std::size_t>(n);
    }
}

void destroy_model(Model* model) {  // made by make_model() in memory from malloc
    model->~Model();
    std::free(model);
}

}  // namespace

void element_name(const Variable& v, std::uint32_t element, char* buffer, std::size_t size) {
    if (v.rows == 0) {
        std::snprintf(buffer, size, "%s", v.name);
    } else if (v.cols == 0) {
        std::snprintf(buffer, size, "%s[%u]", v.name, element + 1);
    } else {
        std::snprintf(buffer, size, "%s[%u,%u]", v.name, element / v.cols + 1, element % v.cols + 1);
    }
}

// ---------------------------------------------------------------------------------------------- life and messages

Instance* Instance::create(const char* name, const char* token, Interface interface, const Log& log) {
    Model* model = make_model();
    if (model == nullptr) return nullptr;
    void* memory = std::malloc(sizeof(Instance));
    if (memory == nullptr) {
        destroy_model(model);
        return nullptr;
    }
    auto* instance = new (memory) Instance(name == nullptr ? "" : name, interface, log, model);
    bool good = instance->memory_ != nullptr;
    if (token == nullptr || std::strcmp(token, instance->token_) != 0) {
        instance->error("token '%.60s' refused: modelDescription.xml and binary do not belong together, expected '%s'",
                        token == nullptr ? "" : token, instance->token_);
        good = false;
    }
    if (name == nullptr || *name == '\0') {
        instance->error("instance name is missing");
        good = false;
    }
    if (!good) {
        destroy(instance);
        return nullptr;
    }
    return instance;
}

Instance::Instance(const char* name, Interface interface, const Log& log, Model* model)
    : interface_(interface), log_(log), model_(model) {
    std::snprintf(name_, sizeof name_, "%s", name);
    make_token(model_->name(), table(), token_);
    model_->reset();
    for (const Variable& v : table()) {
        if (v.role == Role::state) n_states_ += v.size;
        if (is_held(v)) n_held_ += v.size;
        if (v.causality == Causality::output && v.type == Type::float64) n_outputs_ += v.size;
        has_enumerations_ = has_enumerations_ || v.type == Type::enumeration;
        has_texts_ = has_texts_ || v.type == Type::string;
        if (v.causality == Causality::input && v.kind != Kind::any) ++n_checked_inputs_;
        if (v.role == Role::state && v.kind == Kind::unit_quaternion) ++n_unit_states_;
        if (v.role == Role::event) ++n_events_;
        if (v.wakes) ++n_wakes_;
    }
    n_scalars_ = table().next_vr;
    clocks_ = Clocks(table().clocks);
    std::size_t size = 0;
    const auto cut = [this, &size](auto*& pointer, std::size_t n) {  // sizes first, pointers in the second pass
        using Item = std::remove_reference_t<decltype(*pointer)>;
        static_assert(alignof(Item) <= alignof(double));
        pointer = reinterpret_cast<Item*>(static_cast<std::byte*>(memory_) + (memory_ == nullptr ? 0 : size));
        size += (n * sizeof(Item) + sizeof(double) - 1) / sizeof(double) * sizeof(double);
    };
    const auto cut_all = [&] {
        size = 0;
        cut(scalars_, n_scalars_);
        cut(directional_, 2 * std::size_t{n_scalars_});
        cut(events_, n_events_);
        cut(wakes_, n_wakes_);
        cut(settled_states_, reacts() ? n_states_ : 0);
        cut(held_, n_held_);
        cut(before_, n_states_);
        cut(checked_inputs_, n_checked_inputs_);
        cut(unit_states_, n_unit_states_);
        cut(states_, n_states_);
        cut(outputs_, n_outputs_);
        cut(backup_, state_size());
    };
    cut_all();
    memory_ = std::calloc(1, size);
    if (memory_ == nullptr) return;
    cut_all();

    std::size_t state = 0, rate = 0, output = 0, checked_input = 0, unit_state = 0, event = 0, wake = 0;
    for (const Variable& v : table()) {
        const bool is_state = v.role == Role::state;
        const bool computed = (!is_state || reacts()) &&  // an event may change a state
                              (v.causality == Causality::output || v.causality == Causality::local);
        const bool input = v.causality == Causality::input, parameter = v.causality == Causality::parameter;
        const bool early = input || parameter || is_state;
        const bool running = input || (parameter && v.variability == Variability::tunable);
        if (input && v.kind != Kind::any) checked_inputs_[checked_input++] = &v;
        if (is_state && v.kind == Kind::unit_quaternion) unit_states_[unit_state++] = {&v, state};
        const bool is_float = v.type == Type::float64;
        if (v.role == Role::event) events_[event++] = floats(v);
        if (v.wakes) wakes_[wake++] = floats(v);
        const bool bounded = std::isfinite(v.above) || std::isfinite(v.min) || std::isfinite(v.max);
        const bool plain = input && is_float && !bounded;
        const unsigned traits = trait_of(v.type) | (computed ? trait_computed : 0U) | (is_state ? trait_state : 0U) |
                                (v.role == Role::derivative ? trait_rate : 0U) | (early ? trait_set_early : 0U) |
                                (running ? trait_set_running : 0U) | (plain ? 0U : trait_not_plain) |
                                (input && v.kind != Kind::any ? trait_checked : 0U);
        for (std::uint32_t e = 0; e < v.size; ++e) {
            void* data = is_float ? floats(v) + e : v.data;  // all others are scalars
            scalars_[v.vr + e] = {data, &v, e == 0 ? v.size : 0, traits};
            if (is_state) states_[state++].x = floats(v) + e;
            if (v.role == Role::derivative) states_[rate++].rate = floats(v) + e;
            if (v.causality == Causality::output && is_float) outputs_[output++] = floats(v) + e;
        }
    }
    clock_time_ = floats(table().variables[0]);
    if (n_states_ != 0) max_internal_step_ = floats(table().variables[table().count - 1]);
    copy_held(held_, true);
}

Instance::~Instance() {
    std::free(memory_);
    destroy_model(model_);
}

void Instance::destroy(Instance* instance) {
    if (instance == nullptr) return;
    instance->~Instance();
    std::free(instance);
}

void Instance::message(Status status, const char* category, const char* format, std::va_list arguments) {
    if (log_.write == nullptr) return;
    char text[768];
    const int start = std::snprintf(text, sizeof text, "%s '%s': ", model_->name(), name_);
    std::vsnprintf(text + start, sizeof text - static_cast<std::size_t>(start), format, arguments);
    for (char* c = text; *c != '\0'; ++c) {
        if (*c == '%' || *c == '#') *c = ' ';  // FMI 2 loggers read these as directives
    }
    log_.write(log_.context, status, category, text);
}

Status Instance::error(const char* format, ...) {
    std::va_list arguments;
    va_start(arguments, format);
    message(Status::error, log_categories[0].name, format, arguments);
    va_end(arguments);
    return Status::error;
}

Status Instance::beyond(const char* format, ...) {
    const Status status = mode_ == mode_continuous ? Status::discard : Status::error;
    std::va_list arguments;
    va_start(arguments, format);
    message(status, log_categories[0].name, format, arguments);
    va_end(arguments);
    return status;
}

void Instance::event(const char* format, ...) {
    if (!log_events_) return;
    std::va_list arguments;
    va_start(arguments, format);
    message(Status::ok, log_categories[2].name, format, arguments);
    va_end(arguments);
}

void Instance::warning(const char* format, ...) {
    std::va_list arguments;
    va_start(arguments, format);
    message(Status::warning, log_categories[1].name, format, arguments);
    va_end(arguments);
}

bool Instance::refuse(const char* function) {
    const char* now = mode_ == mode_instantiated     ? "before initialization"
                      : mode_ == mode_initialization ? "in initialization mode"
                      : mode_ == mode_event          ? "in event mode"
                      : mode_ == mode_continuous     ? "in continuous-time mode"
                      : mode_ == mode_step           ? "in step mode"
                                                     : "after terminate";
    error("%s may not be called %s", function, now);
    return false;
}

Status Instance::set_debug_logging(bool on, std::size_t n, const char* const* categories) {
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

// --------------------------------------------------------------------------------------------------------- modes

Status Instance::setup(bool stop_defined, double start, double stop) {
    if (!std::isfinite(start)) return error("start time %g is not finite", start);
    if (stop_defined && !(stop >= start)) return error("stop time %g is before start time %g", stop, start);
    stop_defined_ = stop_defined;
    stop_time_ = stop;
    move_to(start);
    return Status::ok;
}

Status Instance::enter_initialization() {
    mode_ = mode_initialization;
    parameters_checked_ = outputs_fresh_ = derivatives_fresh_ = false;
    settled_time_ = time_;
    event("initialization at t = %g", time_);
    return Status::ok;
}

Status Instance::start_clocks() {
    clocks_ = model_->clocks();
    for (Clock& clock : clocks_) {
        if (Status status = resolves(clock, time_); status != Status::ok) return status;
        clock.start(time_);
    }
    clocks_.look_at(time_);
    note_what_holds();
    return Status::ok;
}

void Instance::note_what_holds() {
    sampling_ = 0;
    for (const Variable& v : table()) sampling_ |= v.clock >= 0 ? 1U << v.clock : 0U;
    sampling_ &= clocks_.running();
}

/// Whether two sample instants in a row differ at that time; the index of one then has room in a double, and in 64 bits.
Status Instance::resolves(const Clock& clock, double time) {
    if (!clock.runs() || clock.period >= 4.5e-16 * std::fabs(time)) return Status::ok;  // two units in the last place
    const double resolution = std::nextafter(std::fabs(time), HUGE_VAL) - std::fabs(time);
    if (clock.period >= 2.0 * resolution) return Status::ok;
    return error("at t = %g: the sampling period of %g s is below the resolution of time, which is %.2g s there: %s",
                 time, clock.period, resolution, "let it start nearer to t = 0, or sample less often");
}

/// The parameter that is the sampling period, to name it.
const char* Instance::period_name(const Clock& clock) const {
    for (const Variable& v : table()) {
        if (v.causality == Causality::parameter && v.unit == &unit::s && v.size == 1 && *floats(v) == clock.period) {
            return v.name;
        }
    }
    return "the sampling period";
}

/// Whether what lies between two times can be computed in reasonable time.
Status Instance::fits_budget(double from, double to) {
    const double span = to - from;
    if (n_states_ != 0 && !(span <= step_budget * *max_internal_step_)) {
        return error(
            "a step of %g s needs %.3g internal steps, at most %g are taken: %s, or raise max_internal_step = %g "
            "to %.2g",
            span, span / *max_internal_step_, step_budget, "take smaller steps", *max_internal_step_,
            1.01 * span / step_budget);
    }
    for (const Clock& clock : clocks_) {
        if (clock.runs() && !(span <= step_budget * clock.period)) {
            return error("a step of %g s needs %.3g samples, at most %g are taken: %s, or raise %s = %g to %.2g", span,
                         span / clock.period, step_budget, "take smaller steps", period_name(clock), clock.period,
                         1.01 * span / step_budget);
        }
        if (Status status = resolves(clock, to); status != Status::ok) return status;
    }
    return Status::ok;
}

Status Instance::exit_initialization() {
    const Status status = evaluate();
    if (status != Status::ok) return status;
    mode_ = interface_ == Interface::co_simulation ? mode_step : mode_event;
    return Status::ok;
}

Status Instance::terminate() {
    mode_ = mode_terminated;
    return Status::ok;
}

Status Instance::reset() {
    model_->reset();
    mode_ = mode_instantiated;
    stop_time_ = 0.0;
    said_.clear();
    stop_defined_ = spin_reported_ = settled_ = states_changed_ = false;
    settled_time_ = 0.0;
    settled_signs_ = signs_ = 0;
    clocks_ = Clocks(table().clocks);
    sampling_ = 0;
    copy_held(held_, true);
    move_to(0.0);
    parameters_checked_ = inputs_checked_ = false;
    return Status::ok;
}

// -------------------------------------------------------------------------------------------------------- values

template <Addressing A>
const Instance::Scalar* Instance::find(const char* function, std::uint32_t vr) {
    if (vr < n_scalars_ && count_of<A>(scalars_[vr]) != 0) return &scalars_[vr];
    error("%s: value reference %u is not known", function, vr);
    return nullptr;
}

/// Whether all references are known and stand for so many values; `traits` is what any of them has.
template <Addressing A>
bool Instance::scan(const std::uint32_t* vrs, std::size_t n, std::size_t n_values, unsigned* traits) const {
    const Scalar* scalars = scalars_;
    const std::uint32_t n_scalars = n_scalars_;
    std::size_t count = 0;
    unsigned any = 0;
    for (std::size_t i = 0; i < n; ++i) {
        if (vrs[i] >= n_scalars || count_of<A>(scalars[vrs[i]]) == 0) return false;
        any |= scalars[vrs[i]].traits;
        count += count_of<A>(scalars[vrs[i]]);
    }
    *traits = any;
    return count == n_values;
}

/// What is wrong with references that are not to be read.
template <Addressing A, class P>
Status Instance::check_references(const char* function, const std::uint32_t* vrs, std::size_t n, std::size_t n_values) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const Scalar* s = find<A>(function, vrs[i]);
        if (s == nullptr) return Status::error;
        if ((s->traits & P::traits) == 0) {
            return error("%s: %s has another type", function, s->variable->name);
        }
        count += count_of<A>(*s);
    }
    return count == n_values ? Status::ok : error("%s: %zu values given, %zu expected", function, n_values, count);
}

template <Addressing A, class P>
Status Instance::get(const char* function, const std::uint32_t* vrs, std::size_t n, typename P::Value* values,
                     std::size_t n_values) {
    if ((vrs == nullptr && n != 0) || (values == nullptr && n_values != 0)) return null_pointer(function);
    unsigned traits = 0;
    if (!scan<A>(vrs, n, n_values, &traits) || (traits & trait_types & ~P::traits) != 0) {
        return check_references<A, P>(function, vrs, n, n_values);
    }
    if (mode_ != mode_instantiated) {  // before initialization nothing is computed yet
        if ((traits & trait_rate) != 0 && !derivatives_fresh_) {
            if (Status status = evaluate_derivatives(); status != Status::ok) return status;
        } else if ((traits & trait_computed) != 0 && !outputs_fresh_) {
            if (Status status = evaluate(); status != Status::ok) return status;
        } else if ((traits & trait_state) != 0) {
            if (Status status = check_parameters(); status != Status::ok) return status;
        }
    }
    const Scalar* scalars = scalars_;
    for (std::size_t i = 0; i < n; ++i) {
        const Scalar& s = scalars[vrs[i]];
        const auto* from = static_cast<const typename P::Stored*>(s.data);
        for (std::uint32_t e = 0; e < count_of<A>(s); ++e) *values++ = as_passed<typename P::Value>(from[e]);
    }
    return Status::ok;
}

bool Instance::may_set(const char* function, const Scalar& s) {
    const unsigned wanted =
        (mode_ & (mode_instantiated | mode_initialization)) != 0 ? trait_set_early : trait_set_running;
    if ((s.traits & wanted) != 0) return true;
    error("%s: %s can not be set %s", function, s.variable->name,
          (s.traits & trait_set_early) != 0 ? "after initialization" : "because the component computes it");
    return false;
}

bool Instance::in_range(const char* function, const Variable& v, std::uint32_t element, double value) {
    const bool is_listed = v.type == Type::enumeration ? is_item(v, value)
                           : v.type == Type::boolean   ? value == 0.0 || value == 1.0
                                                       : true;
    if (std::isfinite(value) && is_listed && value > v.above && value >= v.min && value <= v.max) return true;
    char name[128];
    element_name(v, element, name, sizeof name);
    if (v.type == Type::enumeration) {
        char items[256];
        list_items(v, items, sizeof items);
        error("%s: %s = %.17g refused: one of its items is expected, %s", function, name, value, items);
    } else if (v.type == Type::boolean) {
        error("%s: %s = %.17g refused: 0 or 1 is expected", function, name, value);
    } else if (!std::isfinite(value)) {
        error("%s: %s = %g refused: a finite number is expected", function, name, value);
    } else if (!(value > v.above)) {
        error("%s: %s = %g refused: must be above %g", function, name, value, v.above);
    } else if (!(value >= v.min)) {
        error("%s: %s = %g refused: must be at least %g", function, name, value, v.min);
    } else {
        error("%s: %s = %g refused: must be at most %g", function, name, value, v.max);
    }
    return false;
}

template <Addressing A, class P>
Status Instance::check_values(const char* function, const std::uint32_t* vrs, std::size_t n,
                              const typename P::Value* values, std::size_t n_values) {
    std::size_t done = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const Scalar* s = find<A>(function, vrs[i]);
        if (s == nullptr) return Status::error;
        const Variable& v = *s->variable;
        if ((s->traits & P::traits) == 0) return error("%s: %s has another type", function, v.name);
        if (!may_set(function, *s)) return Status::error;
        const std::uint32_t count = count_of<A>(*s);
        if (done + count > n_values) return error("%s: %zu values given, more expected", function, n_values);
        for (std::uint32_t e = 0; e < count; ++e) {
            if (!in_range(function, v, vrs[i] - v.vr + e, as_number(values[done + e]))) return Status::error;
        }
        done += count;
    }
    return done == n_values ? Status::ok : error("%s: %zu values given, %zu expected", function, n_values, done);
}

template <Addressing A, class P>
Status Instance::set(const char* function, const std::uint32_t* vrs, std::size_t n, const typename P::Value* values,
                     std::size_t n_values) {
    if ((vrs == nullptr && n != 0) || (values == nullptr && n_values != 0)) return null_pointer(function);
    // What an importer sets in its loop are finite values of plain inputs: nothing else needs a closer look.
    unsigned traits = 0;
    bool plain = false;
    if constexpr (std::is_same_v<P, Floats>) {
        plain = scan<A>(vrs, n, n_values, &traits) && (traits & trait_not_plain) == 0 && all_finite(values, n_values);
    }
    if (!plain) {  // all values are checked before the first one is stored
        const Status status = check_values<A, P>(function, vrs, n, values, n_values);
        if (status != Status::ok) return status;
        parameters_checked_ = false;
    }
    const Scalar* scalars = scalars_;
    for (std::size_t i = 0; i < n; ++i) {
        const Scalar& s = scalars[vrs[i]];
        auto* to = static_cast<typename P::Stored*>(s.data);
        for (std::uint32_t e = 0; e < count_of<A>(s); ++e) to[e] = static_cast<typename P::Stored>(*values++);
    }
    // scan() may have given up before the end, but then everything is to be checked again
    inputs_checked_ = inputs_checked_ && plain && (traits & trait_checked) == 0;
    outputs_fresh_ = derivatives_fresh_ = false;
    return Status::ok;
}

#define ADCS_VALUES(ADDRESSING, PASSED)                                                                               \
    template Status Instance::get<ADDRESSING, PASSED>(const char*, const std::uint32_t*, std::size_t, PASSED::Value*, \
                                                      std::size_t);                                                   \
    template Status Instance::set<ADDRESSING, PASSED>(const char*, const std::uint32_t*, std::size_t,                 \
                                                      const PASSED::Value*, std::size_t);
ADCS_VALUES(Addressing::scalars, Floats)
ADCS_VALUES(Addressing::scalars, fmi2::IntegersAndItems)
ADCS_VALUES(Addressing::scalars, fmi2::Booleans)
ADCS_VALUES(Addressing::scalars, Texts)
ADCS_VALUES(Addressing::arrays, Floats)
ADCS_VALUES(Addressing::arrays, Integers)
ADCS_VALUES(Addressing::arrays, fmi3::EnumerationItems)
ADCS_VALUES(Addressing::arrays, fmi3::Booleans)
ADCS_VALUES(Addressing::arrays, Texts)
#undef ADCS_VALUES

// --------------------------------------------------------------------------------------------------- evaluation

Status Instance::check_again() {
    const Status status = check_parameters();
    return status == Status::ok ? check_inputs() : status;
}

Status Instance::check_parameters() {
    if (parameters_checked_) return Status::ok;
    for (const Variable& v : table()) {
        if (v.causality == Causality::input || v.kind == Kind::any) continue;
        const bool start_value =
            v.causality == Causality::parameter || (v.role == Role::state && (mode_ & mode_initialization) != 0);
        if (!start_value) continue;
        char fault[320];
        if (!meets_condition(v, fault, sizeof fault)) return error("%s", fault);
        if (is_normalised(v.kind)) normalise(v);
    }
    Words fault;
    model_->validate(fault);
    if (fault.text() != nullptr) return error("%s", fault.text());
    if ((mode_ & mode_initialization) != 0) {
        if (Status status = start_clocks(); status != Status::ok) return status;
    }
    parameters_checked_ = true;
    return Status::ok;
}

Status Instance::check_inputs() {
    if (inputs_checked_) return Status::ok;
    for (std::size_t i = 0; i < n_checked_inputs_; ++i) {
        char fault[320];
        if (is_unit(*checked_inputs_[i]) || meets_condition(*checked_inputs_[i], fault, sizeof fault)) continue;
        return error("at t = %g: input %s", time_, fault);
    }
    inputs_checked_ = true;
    return Status::ok;
}

Status Instance::not_finite(const char* what, bool (*concerned)(const Variable&), const char* way_out) {
    for (const Variable& v : table()) {
        if (v.type != Type::float64 || !concerned(v)) continue;
        for (std::uint32_t e = 0; e < v.size; ++e) {
            if (std::isfinite(floats(v)[e])) continue;
            char name[128];
            element_name(v, e, name, sizeof name);
            return beyond("at t = %g: %s %s is %g%s", time_, what, name, floats(v)[e], way_out);
        }
    }
    return Status::error;
}

// 0 * x is 0 for finite x only, else NaN, and a sum stays so.
Status Instance::finite_rates() {
    double zero = 0.0;
    for (std::size_t i = 0; i < n_states_; ++i) zero += 0.0 * *states_[i].rate;
    return zero == 0.0 ? Status::ok
                       : not_finite("derivative of", [](const Variable& v) { return v.role == Role::derivative; });
}
Status Instance::finite_outputs() {
    const auto concerned = [](const Variable& v) { return v.causality == Causality::output; };
    double zero = 0.0;
    for (std::size_t i = 0; i < n_outputs_; ++i) zero += 0.0 * *outputs_[i];
    return zero == 0.0 ? are_items(concerned) : not_finite("output", concerned);
}
Status Instance::finite_held() {
    const auto concerned = [](const Variable& v) { return v.role == Role::held; };
    double zero = 0.0;
    for (const Variable& v : table()) {
        if (v.type != Type::float64 || !concerned(v)) continue;
        for (std::uint32_t e = 0; e < v.size; ++e) zero += 0.0 * floats(v)[e];
    }
    return zero == 0.0 ? are_items(concerned) : not_finite("sampled", concerned);
}

/// Whether a law has set the enumerations concerned to items of theirs.
Status Instance::are_items(bool (*concerned)(const Variable&)) {
    if (!has_enumerations_) return Status::ok;
    for (const Variable& v : table()) {
        if (v.type != Type::enumeration || !concerned(v) || is_item(v, number_of<double>(v, 0))) continue;
        char items[256];
        list_items(v, items, sizeof items);
        return beyond("at t = %g: %s is %g, which is none of its items: %s", time_, v.name, number_of<double>(v, 0),
                      items);
    }
    return Status::ok;
}

Status Instance::evaluate() {
    if (outputs_fresh_) return Status::ok;
    if (Status status = check(); status != Status::ok) return status;
    const bool pending = at_sample() || happens_now();
    if (pending) undo();
    if (at_sample()) {
        if (Status status = take_samples(); status != Status::ok) return status;
    }
    derivatives_fresh_ = false;
    model_->outputs(holding());
    Status status = finite_outputs();
    if (status == Status::ok && happens_now()) status = react();
    outputs_fresh_ = status == Status::ok;
    if (pending && !outputs_fresh_) undo();
    return status;
}

Status Instance::evaluate_derivatives() {
    if (Status status = evaluate(); status != Status::ok) return status;
    if (derivatives_fresh_) return Status::ok;
    model_->derivatives();
    const Status status = finite_rates();
    derivatives_fresh_ = status == Status::ok;
    return status;
}

void Instance::move_to(double time) {
    time_ = time;
    *clock_time_ = time;
    outputs_fresh_ = derivatives_fresh_ = false;
}

void Instance::read_states(double* x) const {
    for (std::size_t i = 0; i < n_states_; ++i) x[i] = *states_[i].x;
}

void Instance::read_rates(double* xdot) const {
    for (std::size_t i = 0; i < n_states_; ++i) xdot[i] = *states_[i].rate;
}

void Instance::write_states(const double* x) {
    for (std::size_t i = 0; i < n_states_; ++i) *states_[i].x = x[i];
    outputs_fresh_ = derivatives_fresh_ = false;
}

// ------------------------------------------------------------------------------------------------------- samples
// A sample taken at a communication point is tentative, and so is what happens at an event: the importer may still set
// inputs there and read the outputs again. It is repeated from what was before, and counts once time moves on.

void Instance::undo() {
    copy_held(held_, false);
    if (states_changed_) write_states(settled_states_);
    states_changed_ = false;
}

void Instance::copy_held(double* held, bool store) {
    for (const Variable& v : table()) {
        if (!is_held(v)) continue;
        if (v.type != Type::float64) {
            if (store) {
                *held = number_of<double>(v, 0);
            } else {
                set_number<double>(v, 0, *held);
            }
        } else if (store) {
            std::memcpy(held, v.data, v.size * sizeof(double));
        } else {
            std::memcpy(v.data, held, v.size * sizeof(double));
        }
        held += v.size;
    }
}

/// Samples that give no finite values leave the values held before.
Status Instance::take_samples() {
    model_->sample(clocks_);
    const Status status = finite_held();
    if (status != Status::ok) undo();
    return status;
}

/// What was evaluated counts: samples and events, and the outputs that belong to them.
void Instance::commit() {
    clocks_.each_due([this](const Sample& s) { event("sample %lld at t = %g", static_cast<long long>(s.k), time_); });
    copy_held(held_, true);
    clocks_.advance();
    if (said_.text() != nullptr) warning("at t = %g: %s", time_, said_.text());
    said_.clear();
    settled_time_ = time_;
    settled_signs_ = signs_;
    settled_ = true;
    states_changed_ = false;
}

// ------------------------------------------------------------------------------------------------- Co-Simulation

void Instance::normalise_states() {
    for (std::size_t i = 0; i < n_unit_states_; ++i) {
        double* q = floats(*unit_states_[i].variable);  // four numbers, as a law's Quat is
        const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        if (length == 1.0) continue;
        for (int e = 0; e < 4; ++e) q[e] /= length;
    }
}

/// One step of the classical Runge-Kutta method of order 4, after which quaternions are normalised.
Status Instance::step_within(double begin, double h) {
    model_->integrate(begin, h, sampling_, before_);
    normalise_states();
    return finite_states_after(begin, h);
}

/// Equal steps not longer than max_internal_step. Stops before one after which a state were not finite, and where an event
/// function has changed its sign.
Status Instance::integrate(double from, double to) {
    if (n_states_ != 0 && to > from) {
        const double ratio = (to - from) / *max_internal_step_ - 1e-9;
        const double steps = ratio > 1.0 ? std::ceil(ratio) : 1.0;
        const double h = (to - from) / steps;
        for (double i = 0.0; i < steps; ++i) {
            if (Status status = step_within(from + i * h, h); status != Status::ok) return status;
            if (n_events_ == 0) continue;
            bool crossed = false;
            if (Status status = locate(from + i * h, h, crossed); status != Status::ok || crossed) return status;
        }
        move_to(to);
        watch_spin(h);
    } else {
        move_to(to);
    }
    return Status::ok;
}

Status Instance::finite_states(const char* way_out) {
    double zero = 0.0;
    for (std::size_t i = 0; i < n_states_; ++i) zero += 0.0 * *states_[i].x;
    return zero == 0.0 ? Status::ok
                       : not_finite("state", [](const Variable& v) { return v.role == Role::state; }, way_out);
}

Status Instance::finite_states_after(double begin, double h) {
    double zero = 0.0;
    for (std::size_t i = 0; i < n_states_; ++i) zero += 0.0 * *states_[i].x;
    if (zero == 0.0) return Status::ok;
    char way_out[96];
    std::snprintf(way_out, sizeof way_out, ", after an internal step of %g s; max_internal_step makes it smaller", h);
    move_to(begin + h);
    const Status status = not_finite("state", [](const Variable& v) { return v.role == Role::state; }, way_out);
    move_to(begin);
    write_states(before_);
    return status;
}

/// Warns of a body that turns so fast that the Runge-Kutta method loses angle, which renormalising hides. By an angle
/// omega h a quaternion moves by 2 sin(omega h / 4), and the method lags behind by 2 (omega h / 2)^5 / 120 in a step.
void Instance::watch_spin(double h) {
    if (spin_reported_) return;
    const double bound = 60.0 * spin_error_bound * h;  // of (omega h / 2)^5
    for (std::size_t i = 0; i < n_unit_states_; ++i) {
        const double* q = floats(*unit_states_[i].variable);
        const double* before = before_ + unit_states_[i].first;
        double square = 0.0;
        for (int e = 0; e < 4; ++e) square += (q[e] - before[e]) * (q[e] - before[e]);
        if (square * square * square * square * square > bound * bound) return report_spin(i, std::sqrt(square), h);
    }
}

/// A message, and no other status of the step: it did what it was asked for, and tools differ in what they do then.
void Instance::report_spin(std::size_t i, double change, double h) {
    double sine = 0.5 * std::fmin(change, 2.0);  // of omega h / 4; four times halved the angle is small
    for (int halving = 0; halving < 4; ++halving) sine /= std::sqrt(2.0 + 2.0 * std::sqrt(1.0 - sine * sine));
    const double omega = 4.0 * 16.0 * sine * (1.0 + sine * sine / 6.0) / h;
    const double half = 0.5 * omega * h, omega_2 = omega * omega;
    const double lost = half * half * half * half * half / (60.0 * h);
    const double smaller = 0.9 * std::sqrt(std::sqrt(1920.0 * spin_error_bound / (omega_2 * omega_2 * omega)));
    constexpr double degree = 57.295779513082321;
    spin_reported_ = true;
    warning(
        "at t = %g: %s turns by %.3g deg in an internal step of %g s, which loses about %.2g deg/s: set "
        "max_internal_step to %.2g or less",
        time_, unit_states_[i].variable->name, degree * omega * h, h, degree * lost, smaller);
}

Status Instance::do_step(double time, double step) {
    if (!std::isfinite(step) || step <= 0.0)
        return error("step size %g refused: a positive finite number is expected", step);
    if (!(std::fabs(time - time_) <= 1e-9 * (step + std::fabs(time_)))) {
        return error("step from t = %.17g refused: this instance is at t = %.17g", time, time_);
    }
    const double end = time + step;
    if (!std::isfinite(end) || !(end > time)) {
        return error("step size %g refused: from t = %g it leads to t = %g", step, time, end);
    }
    if (stop_defined_ && end > stop_time_ + 1e-9 * (step + std::fabs(stop_time_))) {
        return error("step to t = %.17g refused: the stop time is %.17g", end, stop_time_);
    }
    if (Status status = check(); status != Status::ok) return status;
    if (Status status = fits_budget(time, end); status != Status::ok) return status;
    double from = time;
    for (std::size_t events = 0; events < most_events;) {
        if (at_sample() || reacts()) {
            if (Status status = evaluate(); status != Status::ok) return status;
            commit();
        }
        const double to = std::fmin(clocks_.earliest_before(end), next_wake(from));
        if (Status status = integrate(from, std::fmin(to, end)); status != Status::ok) return status;
        clocks_.look_at(time_);
        if (time_ == end) return Status::ok;
        from = time_;
        if (!at_sample()) ++events;
    }
    return error("%zu events from t = %g to t = %g: what events() sets changes back and forth", most_events, time,
                 time_);
}

// ------------------------------------------------------------------------------------------------ Model Exchange

Status Instance::set_time(double time) {
    if (!std::isfinite(time)) return error("time %g is not finite", time);
    move_to(time);
    return Status::ok;
}

Status Instance::set_states(const double* values, std::size_t n) {
    if (n != n_states_) return error("%zu states given, %zu expected", n, n_states_);
    if (n != 0 && values == nullptr) return null_pointer("set continuous states");
    for (std::size_t i = 0; i < n; ++i) {
        if (!std::isfinite(values[i]))
            return beyond("at t = %g: continuous state %zu = %g refused: a finite number is expected", time_, i + 1,
                          values[i]);
    }
    write_states(values);
    states_changed_ = false;
    return Status::ok;
}

Status Instance::get_states(double* values, std::size_t n) {
    if (n != n_states_) return error("%zu states asked for, there are %zu", n, n_states_);
    if (n != 0 && values == nullptr) return null_pointer("get continuous states");
    if (Status status = check_parameters(); status != Status::ok) return status;
    read_states(values);
    return Status::ok;
}

Status Instance::get_derivatives(double* values, std::size_t n) {
    if (n != n_states_) return error("%zu derivatives asked for, there are %zu", n, n_states_);
    if (n != 0 && values == nullptr) return null_pointer("get derivatives");
    if (Status status = evaluate_derivatives(); status != Status::ok) return status;
    read_rates(values);
    return Status::ok;
}

Status Instance::get_nominals(double* values, std::size_t n) {
    if (n != n_states_) return error("%zu nominals asked for, there are %zu", n, n_states_);
    if (n != 0 && values == nullptr) return null_pointer("get nominals");
    for (const Variable& v : table()) {
        if (v.role != Role::state) continue;
        for (std::uint32_t e = 0; e < v.size; ++e) *values++ = v.nominal;
    }
    return Status::ok;
}

Status Instance::enter_event_mode() {
    mode_ = mode_event;
    clocks_.look_at(time_);
    outputs_fresh_ = outputs_fresh_ && !at_sample() && !reacts();
    return Status::ok;
}

Status Instance::update_discrete_states(Discrete& discrete) {
    if (Status status = evaluate(); status != Status::ok) return status;
    const double next = std::fmin(clocks_.upcoming(), next_wake(time_));
    discrete = {states_changed_, std::isfinite(next), std::isfinite(next) ? next : 0.0};
    return Status::ok;
}

Status Instance::get_event_indicators(double* values, std::size_t n) {
    if (n != n_events_) return error("%zu event indicators asked for, there are %zu", n, n_events_);
    if (n != 0 && values == nullptr) return null_pointer("get event indicators");
    if (Status status = evaluate(); status != Status::ok) return status;
    for (std::size_t i = 0; i < n_events_; ++i) values[i] = *events_[i];
    return Status::ok;
}

Status Instance::enter_continuous_time() {
    if (Status status = evaluate(); status != Status::ok) return status;
    if (at_sample() || reacts()) commit();
    mode_ = mode_continuous;
    return Status::ok;
}

// --------------------------------------------------------------------------------------- directional derivatives

template <Addressing A>
Status Instance::expand(const char* function, const std::uint32_t* vrs, std::size_t n, Directional* scalars,
                        std::size_t n_scalars) {
    std::size_t done = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const Scalar* s = find<A>(function, vrs[i]);
        if (s == nullptr) return Status::error;
        const Variable* v = s->variable;
        if (v->type != Type::float64 || (v->role == Role::held && v->causality != Causality::output) ||
            v->causality == Causality::independent) {
            return error("%s: %s has no derivative", function, v->name);
        }
        const std::uint32_t count = count_of<A>(*s);
        if (done + count > n_scalars || done + count > table().next_vr) {
            return error("%s: %zu values given, more expected", function, n_scalars);
        }
        for (std::uint32_t e = 0; e < count; ++e) scalars[done++].vr = vrs[i] + e;
    }
    return done == n_scalars ? Status::ok : error("%s: %zu values given, %zu expected", function, n_scalars, done);
}

/// Finds the `n_known` and `n_unknown` scalars that are meant and brings the values up to date at which they are to be
/// differentiated.
Status Instance::prepare_derivatives(const char* function, Addressing addressing, const std::uint32_t* unknowns,
                                     std::size_t n_unknowns, std::size_t n_unknown, const std::uint32_t* knowns,
                                     std::size_t n_knowns, std::size_t n_known) {
    const auto scalars = addressing == Addressing::scalars ? &Instance::expand<Addressing::scalars>
                                                           : &Instance::expand<Addressing::arrays>;
    Directional* known = known_scalars();
    Directional* unknown = unknown_scalars();
    if (Status status = (this->*scalars)(function, knowns, n_knowns, known, n_known); status != Status::ok)
        return status;
    if (Status status = (this->*scalars)(function, unknowns, n_unknowns, unknown, n_unknown); status != Status::ok)
        return status;
    for (std::size_t i = 0; i < n_known; ++i) {
        const Variable& v = table().variables[table().owner[known[i].vr]];
        if (v.causality != Causality::input && v.causality != Causality::parameter && v.role != Role::state) {
            return error("%s: %s is not an input, state or parameter", function, v.name);
        }
    }
    for (std::size_t i = 0; i < n_unknown; ++i) {
        const Variable& v = table().variables[table().owner[unknown[i].vr]];
        if (v.causality != Causality::output && v.role != Role::derivative) {
            return error("%s: %s is not an output or derivative", function, v.name);
        }
    }
    if (Status status = evaluate_derivatives(); status != Status::ok) return status;
    if (at_sample()) {
        copy_held(held_, false);
        outputs_fresh_ = derivatives_fresh_ = false;
    }
    return Status::ok;
}

/// The derivatives of the prepared unknowns along `known`, in their `value`: all finite, or an error.
Status Instance::differentiate_along(const char* function, const Directional* known, std::size_t n_known,
                                     std::size_t n_unknown) {
    Directional* unknown = unknown_scalars();
    const char* why = model_->differentiate(known, n_known, unknown, n_unknown, clocks_, holding());
    if (why != nullptr) return error("%s: %s", function, why);
    for (std::size_t i = 0; i < n_unknown; ++i) {
        if (std::isfinite(unknown[i].value)) continue;
        const Variable& v = table().variables[table().owner[unknown[i].vr]];
        char name[128];
        element_name(v, unknown[i].vr - v.vr, name, sizeof name);
        return error("at t = %g: the directional derivative of %s%s is %g", time_,
                     v.role == Role::derivative ? "the derivative of " : "", name, unknown[i].value);
    }
    return Status::ok;
}

Status Instance::differentiate(const char* function, Addressing addressing, const std::uint32_t* unknowns,
                               std::size_t n_unknowns, const std::uint32_t* knowns, std::size_t n_knowns,
                               const double* seed, std::size_t n_seed, double* sensitivity, std::size_t n_sensitivity) {
    if ((n_unknowns != 0 && unknowns == nullptr) || (n_knowns != 0 && knowns == nullptr) ||
        (n_seed != 0 && seed == nullptr) || (n_sensitivity != 0 && sensitivity == nullptr)) {
        return null_pointer(function);
    }
    if (Status status =
            prepare_derivatives(function, addressing, unknowns, n_unknowns, n_sensitivity, knowns, n_knowns, n_seed);
        status != Status::ok) {
        return status;
    }
    Directional* known = known_scalars();
    for (std::size_t i = 0; i < n_seed; ++i) known[i].value = seed[i];
    if (Status status = differentiate_along(function, known, n_seed, n_sensitivity); status != Status::ok)
        return status;
    for (std::size_t i = 0; i < n_sensitivity; ++i) sensitivity[i] = unknown_scalars()[i].value;
    return Status::ok;
}

Status Instance::differentiate_adjoint(const char* function, Addressing addressing, const std::uint32_t* unknowns,
                                       std::size_t n_unknowns, const std::uint32_t* knowns, std::size_t n_knowns,
                                       const double* seed, std::size_t n_seed, double* sensitivity,
                                       std::size_t n_sensitivity) {
    if ((n_unknowns != 0 && unknowns == nullptr) || (n_knowns != 0 && knowns == nullptr) ||
        (n_seed != 0 && seed == nullptr) || (n_sensitivity != 0 && sensitivity == nullptr)) {
        return null_pointer(function);
    }
    if (Status status =
            prepare_derivatives(function, addressing, unknowns, n_unknowns, n_seed, knowns, n_knowns, n_sensitivity);
        status != Status::ok) {
        return status;
    }
    Directional* known = known_scalars();
    if (n_sensitivity == 0) return differentiate_along(function, known, 0, n_seed);
    for (std::size_t i = 0; i < n_sensitivity; ++i) {
        const Directional column{known[i].vr, 1.0};
        if (Status status = differentiate_along(function, &column, 1, n_seed); status != Status::ok) return status;
        double sum = 0.0;
        for (std::size_t j = 0; j < n_seed; ++j) sum += seed[j] * unknown_scalars()[j].value;
        if (!std::isfinite(sum)) {
            const Variable& v = table().variables[table().owner[known[i].vr]];
            char name[128];
            element_name(v, known[i].vr - v.vr, name, sizeof name);
            return error("at t = %g: the adjoint derivative by %s is %g", time_, name, sum);
        }
        known[i].value = sum;
    }
    for (std::size_t i = 0; i < n_sensitivity; ++i) sensitivity[i] = known[i].value;
    return Status::ok;
}

}  // namespace adcs
