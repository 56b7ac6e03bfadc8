// A component behind one interface without templates: what the FMI side needs, and nothing of FMI itself.
#pragma once

#include <type_traits>
#include <utility>

#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

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
    /// The k-th sample: sets what is declared as held.
    virtual void sample(std::int64_t k) = 0;
    virtual SampleTimes sample_times() const = 0;
    /// nullptr, or what is wrong with the parameters.
    virtual const char* validate() const = 0;
    /// unknowns[i].value = sum over knowns of d unknown / d known * known.value; false if not differentiable.
    virtual bool differentiate(const Directional* knowns, std::size_t n_knowns, Directional* unknowns,
                               std::size_t n_unknowns, bool sampling, std::int64_t k) = 0;

    const Table& table() const { return table_; }

protected:
    Table table_;
};

/// The model of the one component that this binary contains; nullptr without memory. Defined by ADCS_EXPORT.
Model* make_model();

namespace detail {

template <class C, class = void>
constexpr bool has_outputs = false;
template <class C>
constexpr bool has_outputs<C, std::void_t<decltype(std::declval<C&>().outputs())>> = true;
template <class C, class = void>
constexpr bool has_derivatives = false;
template <class C>
constexpr bool has_derivatives<C, std::void_t<decltype(std::declval<C&>().derivatives())>> = true;
template <class C, class = void>
constexpr bool has_sample = false;
template <class C>
constexpr bool has_sample<C, std::void_t<decltype(std::declval<C&>().sample(0))>> = true;
template <class C, class = void>
constexpr bool has_validate = false;
template <class C>
constexpr bool has_validate<C, std::void_t<decltype(std::declval<C&>().validate())>> = true;
template <class C, class = void>
constexpr bool is_differentiable = true;
template <class C>
constexpr bool is_differentiable<C, std::void_t<decltype(C::differentiable)>> = C::differentiable;

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
    void sample([[maybe_unused]] std::int64_t k) {
        if constexpr (has_sample<C<T>>) component.sample(k);
    }

    C<T> component{};

private:
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

template <template <class> class C>
class ModelOf final : public Model {
public:
    explicit ModelOf(const char* name) : name_(name), bound_(table_) {}

    const char* name() const override { return name_; }
    void reset() override { bound_.reset(); }
    void outputs() override { bound_.outputs(); }
    void derivatives() override { bound_.derivatives(); }
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
    bool differentiate(const Directional* knowns, std::size_t n_knowns, Directional* unknowns, std::size_t n_unknowns,
                       bool sampling, std::int64_t k) override {
        if constexpr (detail::is_differentiable<C<double>>) {
            dual_.load(table_);
            for (std::size_t i = 0; i < n_knowns; ++i) dual_.scalar(knowns[i].vr).tangent += knowns[i].value;
            dual_.evaluate(sampling, k);
            for (std::size_t i = 0; i < n_unknowns; ++i) unknowns[i].value = dual_.scalar(unknowns[i].vr).tangent;
            return true;
        } else {
            return false;
        }
    }

private:
    struct Nothing {};
    const char* name_;
    detail::Bound<C, double> bound_;
    std::conditional_t<detail::is_differentiable<C<double>>, detail::Shadow<C, Dual>, Nothing> dual_;
};

}  // namespace adcs
