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
void destroy_model(Model* model) {  // made by make_model() in memory from malloc
    model->~Model();
    std::free(model);
}

}  // namespace

// --------------------------------------------------------------------------------------------------------- life

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
    : Messages(model->name(), name, log), interface_(interface), model_(model) {
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

Status Instance::beyond(const char* format, ...) {
    const Status status = mode_ == mode_continuous ? Status::discard : Status::error;
    std::va_list arguments;
    va_start(arguments, format);
    message(status, log_categories[0].name, format, arguments);
    va_end(arguments);
    return status;
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

}  // namespace adcs
