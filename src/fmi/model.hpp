// A component behind one interface without templates: what the FMI side needs, and nothing of FMI itself.
#pragma once

#include <cstdlib>
#include <new>
#include <type_traits>
#include <utility>

#include "fmi/compiler.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"
#include "fmi/shape.hpp"

namespace adcs {

/// A scalar known or unknown of a directional derivative, by its FMI 2 value reference.
struct Directional {
    std::uint32_t vr;
    double value;
};

class Model {
public:
    Model() = default;
    Model(const Model&) = delete;
    Model& operator=(const Model&) = delete;
    virtual ~Model() = default;

    virtual const char* name() const = 0;
    /// All variables back to their start values.
    virtual void reset() = 0;
    /// Every output as a function of time, states and inputs.
    virtual void outputs() = 0;
    /// State derivatives; outputs() has been called for the same time, states and inputs.
    virtual void derivatives() = 0;
    /// One step h of the classical Runge-Kutta method of order 4. Outputs and derivatives belong to no time after it.
    /// `before` (states) receives where it began.
    virtual void integrate(double time, double h, double* before) = 0;
    /// The k-th sample: sets what is declared as held.
    virtual void sample(std::int64_t k) = 0;
    virtual SampleTimes sample_times() const = 0;
    /// nullptr, or what is wrong with the parameters.
    virtual const char* validate() const = 0;
    /// unknowns[i].value = sum over knowns of d unknown / d known * known.value; nullptr, or why it cannot be had.
    virtual const char* differentiate(const Directional* knowns, std::size_t n_knowns, Directional* unknowns,
                                      std::size_t n_unknowns, bool sampling, std::int64_t k) = 0;

    const Table& table() const { return table_; }

protected:
    Table table_;
};

/// The model of the one component that this binary contains; nullptr without memory. Defined by ADCS_EXPORT.
Model* make_model();

namespace detail {

/// Visitors of declare() that pass over everything but what they are for. The compiler sees through them: what remains
/// of an integrator step is what one would write by hand for this component.
struct Ignore {
    struct Refine {
        Refine above(double) { return {}; }
        Refine at_least(double) { return {}; }
        Refine at_most(double) { return {}; }
        Refine nominal(double) { return {}; }
        Refine fixed() { return {}; }
        Refine unit_quaternion() { return {}; }
        Refine unit_vectors() { return {}; }
        Refine directions() { return {}; }
        Refine inertia() { return {}; }
        Refine positive_definite() { return {}; }
        Refine positive_semidefinite() { return {}; }
    };
    template <class... Any>
    void time(Any&&...) {}
    template <class... Any>
    Refine input(Any&&...) {
        return {};
    }
    template <class... Any>
    Refine output(Any&&...) {
        return {};
    }
    template <class... Any>
    Refine parameter(Any&&...) {
        return {};
    }
    template <class... Any>
    Refine seed(Any&&...) {
        return {};
    }
    template <class... Any>
    Refine state(Any&&...) {
        return {};
    }
    template <class... Any>
    Refine held(Any&&...) {
        return {};
    }
};

/// Sets the time as the component sees it.
template <class T>
struct SetTime : Ignore {
    explicit SetTime(double now) : now_(now) {}
    void time(T& t) { t = now_; }

private:
    double now_;
};

/// Calls action(x, xDot, i) for the i-th scalar continuous state.
template <class T, class Action>
struct EachState : Ignore {
    explicit EachState(const Action& action) : action_(action) {}
    template <class X>
    Refine state(const char*, X& x, X& xDot, const Unit&, const char*) {
        if constexpr (std::is_same_v<X, T>) {
            action_(x, xDot, n_++);
        } else {
            for (int e = 0; e < static_cast<int>(X::SizeAtCompileTime); ++e) {
                action_(x.data()[e], xDot.data()[e], n_++);
            }
        }
        return {};
    }

private:
    const Action& action_;
    int n_ = 0;
};

/// A component together with its table and what every component has: time, and the step of its integrator.
template <template <class> class C, class T>
class Bound {
public:
    explicit Bound(Table& table) {
        Declare<T> declare(table);
        declare.output("time", own_time_, unit::s, "simulation time");
        table.variables[0].causality = Causality::independent;
        component.declare(declare);
        bool has_states = false;
        for (const Variable& v : table) has_states = has_states || v.role == Role::state;
        if (has_states) {
            declare
                .parameter("max_internal_step", max_internal_step_, unit::s,
                           "largest step of the Runge-Kutta integrator inside Co-Simulation")
                .fixed()
                .above(0);
        }
    }
    void reset() {
        component = C<T>{};
        max_internal_step_ = 0.01;
    }
    void evaluate(bool sampling, std::int64_t k) {
        if (sampling) sample(k);
        outputs();
        derivatives();
    }
    void outputs() {
        if constexpr (has_outputs<C<T>>) component.outputs();
    }
    void derivatives() {
        if constexpr (has_derivatives<C<T>>) component.derivatives();
    }
    /// Flat and on a copy of the component, so that the compiler drops outputs that no derivative depends on.
    ADCS_FLATTEN void integrate([[maybe_unused]] double time, [[maybe_unused]] double h, [[maybe_unused]] T* before) {
        if constexpr (has_outputs<C<T>> || has_derivatives<C<T>>) {
            C<T> c = component;
            T start[Table::scalar_capacity], sum[Table::scalar_capacity];  // of which the states take the beginning
            each_state(c, [&](const T& x, const T&, int j) {
                before[j] = start[j] = x;
                sum[j] = 0.0;
            });
            const struct {
                double time, weight, advance;
            } stages[] = {
                {time, 1.0, 0.5 * h}, {time + 0.5 * h, 2.0, 0.5 * h}, {time + 0.5 * h, 2.0, h}, {time + h, 1.0, 0.0}};
            for (const auto& stage : stages) {
                SetTime<T> set_time(stage.time);
                c.declare(set_time);
                if constexpr (has_outputs<C<T>>) c.outputs();
                if constexpr (has_derivatives<C<T>>) c.derivatives();
                each_state(c, [&](T& x, const T& k, int j) {
                    sum[j] += stage.weight * k;
                    x = start[j] + stage.advance * k;
                });
            }
            each_state(c, [&](T& x, const T&, int j) { x = start[j] + h / 6.0 * sum[j]; });
            T end[Table::scalar_capacity];
            each_state(c, [&](const T& x, const T&, int j) { end[j] = x; });
            each_state(component, [&](T& x, const T&, int j) { x = end[j]; });
        }
    }
    void sample([[maybe_unused]] std::int64_t k) {
        if constexpr (has_sample<C<T>>) component.sample(k);
    }

    C<T> component{};

private:
    template <class Action>
    static void each_state(C<T>& c, const Action& action) {
        EachState<T, Action> visitor(action);
        c.declare(visitor);
    }
    T own_time_ = 0.0;
    T max_internal_step_ = 0.01;
};

/// The component in a lifted scalar type, loaded with the values of the plain one.
template <template <class> class C, class T>
class Shadow {
public:
    Shadow() : bound_(table_) {}
    void load(const Table& from) {
        for (int i = 0; i < from.count; ++i) {
            const Variable& source = from.variables[i];
            for (std::uint32_t e = 0; e < source.size; ++e) {
                if (source.type == Type::float64) {
                    static_cast<T*>(table_.variables[i].data)[e] = T(static_cast<const double*>(source.data)[e]);
                } else {
                    static_cast<std::int32_t*>(table_.variables[i].data)[e] =
                        static_cast<const std::int32_t*>(source.data)[e];
                }
            }
        }
    }
    T& scalar(std::uint32_t vr) {
        const Variable& v = table_.variables[table_.owner[vr]];
        return static_cast<T*>(v.data)[vr - v.vr];
    }
    void evaluate(bool sampling, std::int64_t k) { bound_.evaluate(sampling, k); }

private:
    Table table_;
    Bound<C, T> bound_;
};

}  // namespace detail

/// A component as a model; without its derivatives it compiles in half the time.
template <template <class> class C, bool differentiable = detail::is_differentiable<C<double>>>
class ModelOf final : public Model {
public:
    explicit ModelOf(const char* name) : name_(name), bound_(table_) {}
    ~ModelOf() override {
        if (dual_ != nullptr) dual_->~Differentiated();
        std::free(dual_);
    }

    const char* name() const override { return name_; }
    void reset() override { bound_.reset(); }
    void outputs() override { bound_.outputs(); }
    void derivatives() override { bound_.derivatives(); }
    void integrate(double time, double h, double* before) override { bound_.integrate(time, h, before); }
    void sample(std::int64_t k) override { bound_.sample(k); }
    SampleTimes sample_times() const override {
        if constexpr (detail::has_sample<C<double>>) {
            return bound_.component.sample_times();
        } else {
            return {};
        }
    }
    const char* validate() const override {
        if constexpr (detail::has_validate<C<double>>) {
            return bound_.component.validate();
        } else {
            return nullptr;
        }
    }
    const char* differentiate(const Directional* knowns, std::size_t n_knowns, Directional* unknowns,
                              std::size_t n_unknowns, bool sampling, std::int64_t k) override {
        if constexpr (differentiable) {
            if (dual_ == nullptr) {
                void* memory = std::malloc(sizeof(Differentiated));
                if (memory == nullptr) return "there is no memory for derivatives";
                dual_ = new (memory) Differentiated;
            }
            dual_->load(table_);
            for (std::size_t i = 0; i < n_knowns; ++i) dual_->scalar(knowns[i].vr).tangent += knowns[i].value;
            dual_->evaluate(sampling, k);
            for (std::size_t i = 0; i < n_unknowns; ++i) unknowns[i].value = dual_->scalar(unknowns[i].vr).tangent;
            return nullptr;
        } else {
            return "this component has no derivatives";
        }
    }

private:
    struct Nothing {};
    using Differentiated = std::conditional_t<differentiable, detail::Shadow<C, Dual>, Nothing>;
    const char* name_;
    detail::Bound<C, double> bound_;
    Differentiated* dual_ = nullptr;  ///< half of an instance, made when derivatives are asked for
};

}  // namespace adcs
