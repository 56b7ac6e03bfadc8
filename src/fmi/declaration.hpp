// What declare() of a component says, as a table. FMI 2 scalars, FMI 3 arrays, the XML, the instantiation token
// and the documentation all come from this table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "attitude/quaternion.hpp"
#include "fmi/clocks.hpp"
#include "fmi/events.hpp"
#include "fmi/units.hpp"

namespace adcs {

/// An enumeration is a std::int32_t in the component, a string a const char* that points to a literal.
enum class Type : std::uint8_t { float64, int32, boolean, enumeration, string };
enum class Causality : std::uint8_t { independent, parameter, input, output, local };
enum class Variability : std::uint8_t { fixed, tunable, discrete, continuous };
enum class Role : std::uint8_t { plain, state, derivative, held, seed, event };
/// A condition on a variable as a whole, beyond bounds of its elements; what each means is said in conditions.hpp.
enum class Kind : std::uint8_t {
    any,
    unit_quaternion,
    unit_vectors,
    directions,
    inertia,
    positive_definite,
    positive_semidefinite,
    rotation,
    increasing,
};

struct Variable {
    const char* name;
    const char* description;
    const Unit* unit;
    void* data;                      ///< first element, in the component
    std::uint32_t vr;                ///< of the first element; element i has vr + i in FMI 2
    std::uint32_t rows, cols, size;  ///< rows = 0: a scalar; cols = 0: a vector
    Type type;
    Causality causality;
    Variability variability;
    Role role = Role::plain;
    Kind kind = Kind::any;
    int derivative_of = -1;                                   ///< index of the state in the table
    double above = -std::numeric_limits<double>::infinity();  ///< exclusive bound
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    double nominal = 1.0;
    int clock = -1;                      ///< between whose instants an output is held; -1: none
    bool wakes = false;                  ///< a time at which events() is called
    const char* wrong = nullptr;         ///< what was said of it that does not fit it
    const char* const* items = nullptr;  ///< of an enumeration: the names of 0, 1, 2, ...
    std::uint32_t n_items = 0;
};

/// The names of an enumeration's items, of which the first is 0, the second 1, and so on.
struct Items {
    template <std::size_t N>
    Items(const char* const (&items)[N])  // NOLINT(google-explicit-constructor): a declaration names the list
        : names(items), count(static_cast<std::uint32_t>(N)) {}
    const char* const* names;
    std::uint32_t count;
};

/// Whether it keeps its value between samples: what sample() sets, and outputs that are held.
inline bool is_held(const Variable& v) { return v.role == Role::held || v.clock >= 0; }

/// A component's variables in the order of declaration; value reference 0 is time.
struct Table {
    static constexpr int capacity = 96;
    static constexpr std::uint32_t scalar_capacity = 1024;
    Variable variables[capacity];
    int count = 0;
    std::uint32_t next_vr = 0;
    std::uint8_t owner[scalar_capacity];  ///< FMI 2 value reference -> index in variables
    int clocks = 0;
    int events = 0;  ///< event functions
    bool overflow = false;

    const Variable* begin() const { return variables; }
    const Variable* end() const { return variables + count; }
};

/// Refines the variable just declared.
class Refine {
public:
    explicit Refine(Variable& v) : v_(v) {}
    Refine& above(double bound) { return v_.above = bound, *this; }
    Refine& at_least(double bound) { return v_.min = bound, *this; }
    Refine& at_most(double bound) { return v_.max = bound, *this; }
    Refine& nominal(double magnitude) { return v_.nominal = magnitude, *this; }
    Refine& fixed() { return v_.variability = Variability::fixed, *this; }
    /// Must have norm 1; a start value is normalised.
    Refine& unit_quaternion() { return v_.kind = Kind::unit_quaternion, *this; }
    /// Each row, or the vector, must have norm 1, as exactly as a quaternion; a start value is normalised.
    Refine& unit_vectors() { return v_.kind = Kind::unit_vectors, *this; }
    /// Each row, or the vector, must have a direction: it may have any length but 0.
    Refine& directions() { return v_.kind = Kind::directions, *this; }
    /// Must be symmetric, positive definite and satisfy the triangle inequality of principal moments.
    Refine& inertia() { return v_.kind = Kind::inertia, *this; }
    /// Must be symmetric, with positive eigenvalues.
    Refine& positive_definite() { return v_.kind = Kind::positive_definite, *this; }
    /// Must be symmetric, without negative eigenvalues.
    Refine& positive_semidefinite() { return v_.kind = Kind::positive_semidefinite, *this; }
    /// Must be orthonormal, with determinant 1: a direction cosine matrix.
    Refine& rotation() { return v_.kind = Kind::rotation, *this; }
    /// Each element must exceed the one before: the times of a table.
    Refine& increasing() { return v_.kind = Kind::increasing, *this; }
    /// What is held is an output, too.
    Refine& output() {
        if (v_.role != Role::held) v_.wrong = " is not held: only v.held(...) has .output()";
        return v_.causality = Causality::output, *this;
    }
    /// When time comes to what is held, events() is called; `never` is none.
    Refine& wakes() {
        if (v_.role != Role::held || v_.size != 1 || v_.type != Type::float64)
            v_.wrong = " is no held time: only a scalar v.held(...) has .wakes()";
        return v_.wakes = true, *this;
    }
    /// outputs() computes this output at the instants of a clock only, and it is held in between; where the clock's period
    /// is 0, at every instant.
    Refine& sampled(int clock = 0) {
        if (v_.role != Role::plain || v_.causality != Causality::output)
            v_.wrong = " is not what outputs() computes: only v.output(...) has .sampled()";
        if (v_.type == Type::string) v_.wrong = " is a text, which is not held (leave .sampled() out)";
        return v_.clock = clock, *this;
    }

private:
    Variable& v_;
};

/// What is declared without a unit: it takes one value after another, and has no derivative.
template <class X>
using WithoutUnit = std::enable_if_t<std::is_same_v<X, bool> || std::is_same_v<X, std::int32_t>>;

/// The visitor handed to declare() of a component of scalar type T.
template <class T>
class Declare {
public:
    explicit Declare(Table& table) : table_(table) {}

    /// Simulation time; every component has it, whether it uses it or not.
    void time(T& t) { table_.variables[0].data = &t; }

    template <class X>
    Refine input(const char* name, X& x, const Unit& unit, const char* description) {
        return add(name, x, unit, description, Causality::input, Variability::continuous);
    }
    template <class X, class = WithoutUnit<X>>
    Refine input(const char* name, X& x, const char* description) {
        return add(name, x, description, Causality::input, Variability::discrete);
    }
    Refine input(const char* name, std::int32_t& x, const Items& items, const char* description) {
        return add(name, x, items, description, Causality::input, Variability::discrete);
    }
    template <class X>
    Refine output(const char* name, X& x, const Unit& unit, const char* description) {
        return add(name, x, unit, description, Causality::output, Variability::continuous);
    }
    template <class X, class = WithoutUnit<X>>
    Refine output(const char* name, X& x, const char* description) {
        return add(name, x, description, Causality::output, Variability::discrete);
    }
    Refine output(const char* name, std::int32_t& x, const Items& items, const char* description) {
        return add(name, x, items, description, Causality::output, Variability::discrete);
    }
    /// What a component wants to say. outputs() points it to literals, which are there as long as the component.
    Refine output(const char* name, const char*& x, const char* description) {
        return Refine(append(
            {name, description, &unit::one, &x, 0, 0, 0, 1, Type::string, Causality::output, Variability::discrete}));
    }
    /// Tunable during a run unless .fixed().
    template <class X>
    Refine parameter(const char* name, X& x, const Unit& unit, const char* description) {
        return add(name, x, unit, description, Causality::parameter, Variability::tunable);
    }
    template <class X, class = WithoutUnit<X>>
    Refine parameter(const char* name, X& x, const char* description) {
        return add(name, x, description, Causality::parameter, Variability::tunable);
    }
    Refine parameter(const char* name, std::int32_t& x, const Items& items, const char* description) {
        return add(name, x, items, description, Causality::parameter, Variability::tunable);
    }
    /// The seed of what sample() draws from the component's stream. It is declared as such so that whoever puts several
    /// components of a kind into one system can tell by more than a name which parameter has to differ.
    Refine seed(const char* name, std::int32_t& x, const char* description) {
        Refine refine = parameter(name, x, description).fixed().at_least(0);
        table_.variables[table_.count - 1].role = Role::seed;
        return refine;
    }
    /// A continuous state, which is an output too, and its time derivative `der(name)`.
    template <class X>
    Refine state(const char* name, X& x, X& derivative, const Unit& unit, const char* description) {
        const int index = table_.count;
        Refine refine = output(name, x, unit, description);
        table_.variables[index].role = Role::state;
        add(name, derivative, unit, description, Causality::local, Variability::continuous);  // per second: unit_of.hpp
        Variable& rate = table_.variables[table_.count - 1];
        rate.role = Role::derivative;
        rate.derivative_of = index;
        return refine;
    }
    /// A clock: sample() is called at the instants offset + k * period, k = 0, 1, ...; with a period of 0, never. Both are
    /// what the parameters say at initialization.
    void sampled(const T& /*period*/, const T& /*offset*/ = 0.0) {
        table_.overflow = table_.overflow || table_.clocks == Clocks::capacity;
        ++table_.clocks;
    }
    /// An event function, set by outputs(): where it becomes positive, or is no longer, events() is called, at the very time.
    void event(const char* name, T& x, const Unit& unit, const char* description) {
        table_.overflow = table_.overflow || table_.events == Events::capacity;
        ++table_.events;
        add(name, x, unit, description, Causality::local, Variability::continuous);
        table_.variables[table_.count - 1].role = Role::event;
    }
    /// Set by sample() and events() only, and held in between.
    template <class X>
    Refine held(const char* name, X& x, const Unit& unit, const char* description) {
        return hold(add(name, x, unit, description, Causality::local, Variability::discrete));
    }
    template <class X, class = WithoutUnit<X>>
    Refine held(const char* name, X& x, const char* description) {
        return hold(add(name, x, description, Causality::local, Variability::discrete));
    }
    Refine held(const char* name, std::int32_t& x, const Items& items, const char* description) {
        return hold(add(name, x, items, description, Causality::local, Variability::discrete));
    }

private:
    Refine hold(Refine refine) {
        table_.variables[table_.count - 1].role = Role::held;
        return refine;
    }
    Refine add(const char* name, bool& x, const char* description, Causality c, Variability v) {
        return Refine(append({name, description, &unit::one, &x, 0, 0, 0, 1, Type::boolean, c, v}));
    }
    Refine add(const char* name, std::int32_t& x, const char* description, Causality c, Variability v) {
        return Refine(append({name, description, &unit::one, &x, 0, 0, 0, 1, Type::int32, c, v}));
    }
    Refine add(const char* name, std::int32_t& x, const Items& items, const char* description, Causality c,
               Variability v) {
        Variable& added = append({name, description, &unit::one, &x, 0, 0, 0, 1, Type::enumeration, c, v});
        added.items = items.names;
        added.n_items = items.count;
        return Refine(added);
    }
    Refine add(const char* name, T& x, const Unit& unit, const char* description, Causality c, Variability v) {
        return Refine(append({name, description, &unit, &x, 0, 0, 0, 1, Type::float64, c, v}));
    }
    template <int N>
    Refine add(const char* name, Eigen::Matrix<T, N, 1>& x, const Unit& unit, const char* description, Causality c,
               Variability v) {
        return Refine(append({name, description, &unit, x.data(), 0, N, 0, N, Type::float64, c, v}));
    }
    template <int N, int M>
    Refine add(const char* name, Eigen::Matrix<T, N, M, Eigen::RowMajor>& x, const Unit& unit, const char* description,
               Causality c, Variability v) {
        return Refine(append({name, description, &unit, x.data(), 0, N, M, N * M, Type::float64, c, v}));
    }
    /// Of what can be no variable; an exact match above goes before it.
    template <class X>
    Refine add(const char* name, X&, const Unit& unit, const char* description, Causality c, Variability v) {
        static_assert(!std::is_const_v<X>,
                      "a variable is const, or declare() is, and all of them with it (leave `const` out)");
        if constexpr (std::is_base_of_v<Eigen::EigenBase<X>, X>) {
            static_assert(std::is_same_v<typename Eigen::internal::traits<X>::Scalar, T>,
                          "a vector or matrix of another type than T carries no derivatives (write Vec3<T>, Quat<T>, "
                          "Mat3<T> or Eigen::Matrix<T, ...>)");
            static_assert(!std::is_same_v<typename Eigen::internal::traits<X>::Scalar, T>,
                          "a matrix has a fixed size, in rows as FMI has them (write Mat3<T> or Eigen::Matrix<T, 2, 4, "
                          "Eigen::RowMajor>)");
        } else if constexpr (!std::is_const_v<X>) {
            static_assert(!std::is_same_v<X, X>,
                          "a variable of another type than T, such as double, carries no derivatives (write T, "
                          "Vec3<T>, Quat<T> or Mat3<T>; a bool or std::int32_t has no unit)");
        }
        return Refine(append({name, description, &unit, nullptr, 0, 0, 0, 0, Type::float64, c, v}));
    }
    Variable& append(Variable v) {
        if (table_.count == Table::capacity || table_.next_vr + v.size > Table::scalar_capacity) {
            table_.overflow = true;
            return table_.variables[Table::capacity - 1];
        }
        v.vr = table_.next_vr;
        for (; table_.next_vr < v.vr + v.size; ++table_.next_vr) {
            table_.owner[table_.next_vr] = static_cast<std::uint8_t>(table_.count);
        }
        return table_.variables[table_.count++] = v;
    }

    Table& table_;
};

}  // namespace adcs
