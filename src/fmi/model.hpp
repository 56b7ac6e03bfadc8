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
#include "fmi/values.hpp"

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
    /// Every output as a function of time, states and inputs, but those that are held by one of the clocks `holding` now.
    virtual void outputs(unsigned holding) = 0;
    /// State derivatives; outputs() has been called for the same time, states and inputs.
    virtual void derivatives() = 0;
    /// One step h of the classical Runge-Kutta method of order 4. Outputs and derivatives belong to no time after it.
    /// `before` (states) receives where it began.
    virtual void integrate(double time, double h, unsigned holding, double* before) = 0;
    /// Sets what is declared as held, by the samples that are due.
    virtual void sample(const Clocks& clocks) = 0;
    /// Sets what is declared as held, and states, by how things are at an event; outputs() has been called before.
    virtual void events(const Events& e) = 0;
    virtual bool has_events() const = 0;
    /// Periods and offsets as the parameters are now.
    virtual Clocks clocks() = 0;
    /// Says what is wrong with the parameters.
    virtual void validate(Words& refuse) const = 0;
    /// unknowns[i].value = sum over knowns of d unknown / d known * known.value; nullptr, or why it cannot be had.
    virtual const char* differentiate(const Directional* knowns, std::size_t n_knowns, Directional* unknowns,
                                      std::size_t n_unknowns, const Clocks& clocks, unsigned holding) = 0;

    const Table& table() const { return table_; }

protected:
    Table table_;
};

/// The model of the one component that this binary contains; nullptr without memory. Defined by ADCS_EXPORT.
Model* make_model();

namespace detail {

/// Refinements of a variable that change nothing of it, each of which returns what the visitor's input() and the like do.
template <class Self>
struct AsItIs {
    Self& above(double) { return self(); }
    Self& at_least(double) { return self(); }
    Self& at_most(double) { return self(); }
    Self& nominal(double) { return self(); }
    Self& fixed() { return self(); }
    Self& unit_quaternion() { return self(); }
    Self& unit_vectors() { return self(); }
    Self& directions() { return self(); }
    Self& inertia() { return self(); }
    Self& positive_definite() { return self(); }
    Self& positive_semidefinite() { return self(); }
    Self& rotation() { return self(); }
    Self& increasing() { return self(); }
    Self& output() { return self(); }
    Self& wakes() { return self(); }
    Self& sampled(int = 0) { return self(); }

private:
    Self& self() { return static_cast<Self&>(*this); }
};

/// Visitors of declare() that pass over everything but what they are for. The compiler sees through them: what remains
/// of an integrator step is what one would write by hand for this component.
struct Ignore {
    struct Refine : AsItIs<Refine> {};
    template <class... Any>
    void time(Any&&...) {}
    template <class... Any>
    void sampled(Any&&...) {}
    template <class... Any>
    void event(Any&&...) {}
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

/// Reads periods and offsets.
template <class T>
struct ReadClocks : Ignore {
    Clocks clocks;
    void sampled(const T& period, const T& offset = 0.0) { clocks.add(value_of(period), value_of(offset)); }
};

/// Calls action(x, i) for the i-th number of the outputs that are held by one of the clocks `holding`.
template <class T, class Action>
class EachHeldOutput : public Ignore {
public:
    EachHeldOutput(unsigned holding, const Action& action) : holding_(holding), action_(action) {}
    template <class X>
    struct Output : AsItIs<Output<X>> {
        Output(X& output, EachHeldOutput& each) : x(output), visitor(each) {}
        Output& sampled(int clock = 0) {
            if ((visitor.holding_ >> clock & 1U) != 0) visitor.visit(x);
            return *this;
        }
        X& x;
        EachHeldOutput& visitor;
    };
    template <class X, class... Any>
    Output<X> output(const char*, X& x, Any&&...) {
        return {x, *this};
    }

private:
    template <class X>
    void visit(X& x) {
        if constexpr (std::is_same_v<X, T>) {
            action_(x, n_++);
        } else if constexpr (std::is_arithmetic_v<X>) {  // as a number, as long as it is looked at
            T number = static_cast<double>(x);
            action_(number, n_++);
            x = static_cast<X>(value_of(number));
        } else if constexpr (!std::is_pointer_v<X>) {
            for (int e = 0; e < static_cast<int>(X::SizeAtCompileTime); ++e) action_(x.data()[e], n_++);
        }
    }
    unsigned holding_;
    const Action& action_;
    int n_ = 0;
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
    void evaluate(const Clocks& clocks, unsigned holding) {
        sample(clocks);
        outputs(holding);
        derivatives();
    }
    void outputs(unsigned holding) {
        if (holding == 0) return outputs_of(component);
        T held[Table::scalar_capacity];
        each_held_output(component, holding, [&](const T& y, int j) { held[j] = y; });
        outputs_of(component);
        each_held_output(component, holding, [&](T& y, int j) { y = held[j]; });
    }
    void derivatives() {
        if constexpr (has_derivatives<C<T>>) component.derivatives();
    }
    /// Flat and on a copy of the component, so that the compiler drops outputs that no derivative depends on.
    ADCS_FLATTEN void integrate([[maybe_unused]] double time, [[maybe_unused]] double h,
                                [[maybe_unused]] unsigned holding, [[maybe_unused]] T* before) {
        if constexpr (has_outputs<C<T>> || has_derivatives<C<T>>) {
            C<T> c = component;
            T start[Table::scalar_capacity], sum[Table::scalar_capacity];  // of which the states take the beginning
            T held[Table::scalar_capacity];
            if (holding != 0) each_held_output(c, holding, [&](const T& y, int j) { held[j] = y; });
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
                outputs_of(c);
                if (holding != 0) each_held_output(c, holding, [&](T& y, int j) { y = held[j]; });
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
    void sample([[maybe_unused]] const Clocks& clocks) {
        if constexpr (has_sample<C<T>>) clocks.each_due([this](const Sample& s) { component.sample(s); });
    }
    void events([[maybe_unused]] const Events& e) {
        if constexpr (has_events<C<T>>) component.events(e);
    }
    Clocks clocks() {
        ReadClocks<T> read;
        component.declare(read);
        return read.clocks;
    }

    C<T> component{};

private:
    static void outputs_of([[maybe_unused]] C<T>& c) {
        if constexpr (has_outputs<C<T>>) c.outputs();
    }
    template <class Action>
    static void each_held_output(C<T>& c, unsigned holding, const Action& action) {
        EachHeldOutput<T, Action> visitor(holding, action);
        c.declare(visitor);
    }
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
                set_number<T>(table_.variables[i], e, number_of<double>(source, e));
            }
        }
    }
    T& scalar(std::uint32_t vr) {
        const Variable& v = table_.variables[table_.owner[vr]];
        return static_cast<T*>(v.data)[vr - v.vr];
    }
    void evaluate(const Clocks& clocks, unsigned holding) { bound_.evaluate(clocks, holding); }

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
    void outputs(unsigned holding) override { bound_.outputs(holding); }
    void derivatives() override { bound_.derivatives(); }
    void integrate(double time, double h, unsigned holding, double* before) override {
        bound_.integrate(time, h, holding, before);
    }
    void sample(const Clocks& clocks) override { bound_.sample(clocks); }
    void events(const Events& e) override { bound_.events(e); }
    bool has_events() const override { return detail::has_events<C<double>>; }
    Clocks clocks() override { return bound_.clocks(); }
    void validate([[maybe_unused]] Words& refuse) const override {
        if constexpr (detail::has_validate<C<double>>) bound_.component.validate(refuse);
    }
    const char* differentiate(const Directional* knowns, std::size_t n_knowns, Directional* unknowns,
                              std::size_t n_unknowns, const Clocks& clocks, unsigned holding) override {
        if constexpr (differentiable) {
            if (dual_ == nullptr) {
                void* memory = std::malloc(sizeof(Differentiated));
                if (memory == nullptr) return "there is no memory for derivatives";
                dual_ = new (memory) Differentiated;
            }
            dual_->load(table_);
            for (std::size_t i = 0; i < n_knowns; ++i) dual_->scalar(knowns[i].vr).tangent += knowns[i].value;
            dual_->evaluate(clocks, holding);
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
