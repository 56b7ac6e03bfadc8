// One FMU instance: its mode, time, values, integrator and sampling clock. FMI 2 and FMI 3 are thin layers on this.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fmi/messages.hpp"
#include "fmi/model.hpp"

namespace adcs {

enum class Interface : std::uint8_t { model_exchange, co_simulation };
/// FMI 2 addresses scalars, FMI 3 whole arrays by the reference of their first element.
enum class Addressing : std::uint8_t { scalars, arrays };

/// How values come and go: as what an FMI function passes them, what the component has them as, and variables of which types
/// it is for.
template <class AsPassed, class AsStored, Type... types>
struct Passed {
    using Value = AsPassed;
    using Stored = AsStored;
    static constexpr unsigned traits = ((1U << static_cast<unsigned>(types)) | ...);
};
using Floats = Passed<double, double, Type::float64>;
using Integers = Passed<std::int32_t, std::int32_t, Type::int32>;
using Texts = Passed<const char*, const char*, Type::string>;
namespace fmi2 {
using IntegersAndItems = Passed<std::int32_t, std::int32_t, Type::int32, Type::enumeration>;
using Booleans = Passed<std::int32_t, bool, Type::boolean>;
}  // namespace fmi2
namespace fmi3 {
using EnumerationItems = Passed<std::int64_t, std::int32_t, Type::enumeration>;
using Booleans = Passed<std::uint8_t, bool, Type::boolean>;  // of which a tool may pass others than 0 and 1
}  // namespace fmi3

/// Modes as bits, so that a set of allowed modes is one number.
enum Mode : unsigned {
    mode_instantiated = 1,
    mode_initialization = 2,
    mode_event = 4,
    mode_continuous = 8,
    mode_step = 16,
    mode_terminated = 32,
};
inline constexpr unsigned mode_running = mode_event | mode_continuous | mode_step;
inline constexpr unsigned mode_readable = mode_initialization | mode_running | mode_terminated;

/// What an importer of Model Exchange is told of an event.
struct Discrete {
    bool states_changed = false, next_event_defined = false;
    double next_event = 0.0;
};

/// Events in one doStep: so many are a component that switches back and forth.
inline constexpr std::size_t most_events = 1000000;

/// Internal steps, and samples, that one doStep takes at most: minutes of computing. More is a mistake in a unit, or a
/// step that will never end.
inline constexpr double step_budget = 1e8;

class Instance : public Messages {
public:
    /// nullptr without memory or if the token is not this binary's; the log says why.
    static Instance* create(const char* name, const char* token, Interface interface, const Log& log);
    static void destroy(Instance* instance);

    /// True in one of the modes; else logs that `function` may not be called now.
    bool allowed(unsigned modes, const char* function) { return (mode_ & modes) != 0 || refuse(function); }
    Interface interface() const { return interface_; }
    const Table& table() const { return model_->table(); }

    Status setup(bool stop_defined, double start, double stop);
    Status enter_initialization();
    Status exit_initialization();
    Status terminate();
    Status reset();

    // Templated on the addressing so that the loops over scalars have no inner loop.
    template <Addressing A, class P>
    Status get(const char* function, const std::uint32_t* vrs, std::size_t n, typename P::Value* values,
               std::size_t n_values);
    template <Addressing A, class P>
    Status set(const char* function, const std::uint32_t* vrs, std::size_t n, const typename P::Value* values,
               std::size_t n_values);

    Status differentiate(const char* function, Addressing, const std::uint32_t* unknowns, std::size_t n_unknowns,
                         const std::uint32_t* knowns, std::size_t n_knowns, const double* seed, std::size_t n_seed,
                         double* sensitivity, std::size_t n_sensitivity);
    /// The transpose: `seed` is of the unknowns, `sensitivity` of the knowns. One directional derivative for each known.
    Status differentiate_adjoint(const char* function, Addressing, const std::uint32_t* unknowns,
                                 std::size_t n_unknowns, const std::uint32_t* knowns, std::size_t n_knowns,
                                 const double* seed, std::size_t n_seed, double* sensitivity,
                                 std::size_t n_sensitivity);

    // Co-Simulation
    /// After an error time() is what was reached, and states and held values belong to it.
    Status do_step(double time, double step);
    double time() const { return time_; }

    // Model Exchange
    std::size_t states() const { return n_states_; }
    Status set_time(double time);
    Status set_states(const double* values, std::size_t n);
    Status get_states(double* values, std::size_t n);
    Status get_derivatives(double* values, std::size_t n);
    Status get_nominals(double* values, std::size_t n);
    Status enter_event_mode();
    Status update_discrete_states(Discrete& discrete);
    std::size_t event_indicators() const { return n_events_; }
    Status get_event_indicators(double* values, std::size_t n);
    Status enter_continuous_time();

    // Saved states, saved_state.cpp. They are bytes that another instance of the same component can read, and are the
    // same in memory and serialised. What was saved continues to the bit: with the values go the mode, the clock and what
    // is known about the values (computed, checked). Not the settings of the log, which belong to whoever reads it.
    std::size_t state_size() const;
    Status restore(const char* function, const void* state);
    /// Into `state`, which is allocated with malloc where it is null.
    Status save_new(const char* function, void** state);
    Status serialize(const char* function, const void* state, void* bytes, std::size_t size);
    Status deserialize(const char* function, const void* bytes, std::size_t size, void** state);
    /// After which a pointer to it is known not to be a saved state, as long as its memory is not used again.
    static void free_state(void** state);

    /// Of a state at which a law has no values. In continuous-time mode an integrator has tried it, and may try one
    /// nearer: fmi2Discard and fmi3Discard.
    Status beyond(const char* format, ...) ADCS_PRINTF_LIKE(2, 3);

private:
    bool refuse(const char* function);
    Instance(const char* name, Interface interface, const Log& log, Model* model);
    ~Instance();

    /// Properties of a value reference as bits, so that a loop over many can gather what any of them has.
    enum Trait : unsigned {
        trait_types = 31,         ///< a bit for each type
        trait_computed = 32,      ///< an output or local that is no state, or a state that events may change
        trait_rate = 64,          ///< a state derivative
        trait_set_early = 128,    ///< may be set until initialization is over
        trait_set_running = 256,  ///< may be set afterwards
        trait_not_plain = 512,    ///< not a float64 input without bounds, which takes any finite value at any time
        trait_checked = 1024,     ///< input with a condition on the whole array
        trait_state = 2048,       ///< there without a computation, once its start value is normalised
    };
    static constexpr unsigned trait_of(Type type) { return 1U << static_cast<unsigned>(type); }
    /// What the hot path needs of one value reference.
    struct Scalar {
        void* data;
        const Variable* variable;
        std::uint32_t array_size;  ///< elements of the array that starts here; 0 inside an array
        unsigned traits;
    };
    /// A unit quaternion among the states, which begins with the scalar state `first`.
    struct UnitState {
        const Variable* variable;
        std::size_t first;
    };
    /// A scalar continuous state and its derivative.
    struct State {
        double* x;
        const double* rate;
    };

    template <Addressing A>
    static std::uint32_t count_of(const Scalar& s) {
        return A == Addressing::scalars ? 1 : s.array_size;
    }
    template <Addressing A>
    const Scalar* find(const char* function, std::uint32_t vr);
    template <Addressing A>
    bool scan(const std::uint32_t* vrs, std::size_t n, std::size_t n_values, unsigned* traits) const;
    template <Addressing A, class P>
    Status check_references(const char* function, const std::uint32_t* vrs, std::size_t n, std::size_t n_values);
    template <Addressing A, class P>
    Status check_values(const char* function, const std::uint32_t* vrs, std::size_t n, const typename P::Value* values,
                        std::size_t n_values);
    bool may_set(const char* function, const Scalar& s);
    bool in_range(const char* function, const Variable& v, std::uint32_t element, double value);
    template <Addressing A>
    Status expand(const char* function, const std::uint32_t* vrs, std::size_t n, Directional* scalars,
                  std::size_t n_scalars);
    Status prepare_derivatives(const char* function, Addressing, const std::uint32_t* unknowns, std::size_t n_unknowns,
                               std::size_t n_unknown, const std::uint32_t* knowns, std::size_t n_knowns,
                               std::size_t n_known);
    Status differentiate_along(const char* function, const Directional* known, std::size_t n_known,
                               std::size_t n_unknown);
    Directional* known_scalars() { return directional_; }
    Directional* unknown_scalars() { return directional_ + n_scalars_; }

    /// Parameters and inputs make sense; looks at them again only after they were set.
    Status check() { return parameters_checked_ && inputs_checked_ ? Status::ok : check_again(); }
    Status check_again();
    Status check_parameters();
    Status check_inputs();
    Status evaluate();
    Status evaluate_derivatives();
    void move_to(double time);
    Status start_clocks();
    void note_what_holds();
    Status resolves(const Clock& clock, double time);
    Status fits_budget(double from, double to);
    const char* period_name(const Clock& clock) const;
    // Events, events.cpp
    bool reacts() const { return n_events_ + n_wakes_ != 0; }
    bool happens_now() const { return reacts() && mode_ != mode_continuous; }
    Status react();
    bool is_due(const Events& e) const;
    void undo();
    unsigned signs() const;
    unsigned event_bits() const { return n_events_ == 32 ? ~0U : (1U << n_events_) - 1U; }
    Status locate(double begin, double h, bool& crossed);
    double next_wake(double time) const;
    bool at_sample() const { return clocks_.due() != 0; }
    unsigned holding() const { return sampling_ & ~clocks_.due(); }
    Status take_samples();
    void commit();
    void copy_held(double* held, bool store);
    Status integrate(double from, double to);
    Status step_within(double begin, double h);
    void watch_spin(double h);
    void report_spin(std::size_t i, double change, double h);
    void normalise_states();
    void write_states(const double* x);
    void read_states(double* x) const;
    void read_rates(double* xdot) const;
    Status finite_states_after(double begin, double h);
    Status finite_rates();
    Status finite_outputs();
    Status finite_held();
    Status are_items(bool (*concerned)(const Variable&));
    Status finite_states(const char* way_out);
    /// The error for the first value that is not finite among the variables concerned; `way_out` may be empty.
    Status not_finite(const char* what, bool (*concerned)(const Variable&), const char* way_out = "");

    void save(std::byte* bytes) const;
    void load(const std::byte* bytes);
    Status check_saved(const char* function, const void* bytes, std::size_t size);
    Status check_loaded(const char* function);
    bool fits(const Clock& clock, const Clock& expected, bool due) const;

    Interface interface_;
    Model* model_;
    char token_[40]{};
    std::size_t n_states_ = 0, n_outputs_ = 0, n_held_ = 0, n_checked_inputs_ = 0, n_unit_states_ = 0;
    bool has_enumerations_ = false, has_texts_ = false;
    std::size_t n_events_ = 0, n_wakes_ = 0;
    // One block of memory, cut up in the constructor; where things are, so that the loop need not search the table.
    void* memory_ = nullptr;
    Scalar* scalars_;  ///< by FMI 2 value reference
    std::uint32_t n_scalars_;
    Directional* directional_;
    State* states_;
    const double** outputs_;
    const Variable** checked_inputs_;  ///< inputs with a condition on the whole of them
    UnitState* unit_states_;
    const double** events_;   ///< event functions
    const double** wakes_;    ///< held times at which something happens
    double* settled_states_;  ///< states before the pending event
    double* held_;            ///< held values before the pending sample
    double* before_;          ///< states at the start of the latest internal step
    std::byte* backup_;       ///< scratch of restore()
    double* clock_time_;      ///< time as the component sees it
    const double* max_internal_step_ = nullptr;

    Mode mode_ = mode_instantiated;
    double time_ = 0.0;
    double stop_time_ = 0.0;
    bool stop_defined_ = false;
    Clocks clocks_;                ///< samples that are due count once time moves on
    double settled_time_ = 0.0;    ///< when something happened for good, and
    unsigned settled_signs_ = 0;   ///< the event functions that were positive then, as bits
    unsigned signs_ = 0;           ///< those that are now
    bool settled_ = false;         ///< what happens at the start of the run has happened
    Words said_;                   ///< at the pending event
    bool states_changed_ = false;  ///< by the pending event
    unsigned sampling_ = 0;        ///< the clocks that run and between whose instants outputs are held
    bool outputs_fresh_ = false;   ///< outputs belong to the present time, states and inputs
    bool derivatives_fresh_ = false;
    bool parameters_checked_ = false;
    bool inputs_checked_ = false;
    bool spin_reported_ = false;  ///< one warning is enough
};

template <Addressing A>
const Instance::Scalar* Instance::find(const char* function, std::uint32_t vr) {
    if (vr < n_scalars_ && count_of<A>(scalars_[vr]) != 0) return &scalars_[vr];
    error("%s: value reference %u is not known", function, vr);
    return nullptr;
}

/// "q_BN[2]", "J_B[1,3]" or the bare name of a scalar.
void element_name(const Variable& v, std::uint32_t element, char* buffer, std::size_t size);

}  // namespace adcs
