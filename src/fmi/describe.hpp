// Host side only: what the describe program does for one component. There is no model of it: an integrator and
// derivatives that nobody asks would take most of the time to compile.
#pragma once

#include "fmi/shape.hpp"
#include "fmi/trace.hpp"

namespace adcs {

/// What is printed.
struct Description {
    const char* name;
    const char* summary;
    const char* reference;
    bool differentiable;
    const Table& table;
    const Dependencies& dependencies;
    const Dependencies& at_start;  ///< what is more at initialization: the first sample is that of the start time
};
void print(const Description& description);

/// What sets the variables of a component.
struct Functions {
    bool outputs, derivatives, sample, events;
};

/// The exit code for a mistake in the header. What is printed then is a text by which its line is found, a tab, and words.
constexpr int declares_wrong = 2;

/// These print what is wrong and return false. The last two are asked after what is to be set was unset, and the
/// function in question called.
bool is_declared_right(const Table& table, const Functions& has);
bool are_outputs_set(const Table& table);
bool are_derivatives_set(const Table& table);

/// Gives outputs and derivatives values that no law computes. Where one stays, or comes of it, what a run gives depends
/// on what was called before.
void unset(const Table& table);

/// Prints the description of a component, or what is wrong with it; returns what main() does.
template <template <class> class C>
int describe(const char* name) {
    Table table;
    detail::Bound<C, double> component(table);
    component.reset();
    detail::Ignore model;  // stands for the other visitors of declare(), which a model has
    component.component.declare(model);
    constexpr Functions has{detail::has_outputs<C<double>>, detail::has_derivatives<C<double>>,
                            detail::has_sample<C<double>>, detail::has_events<C<double>>};
    if (!is_declared_right(table, has)) return declares_wrong;
    component.sample(all_due(component.clocks(), 0, true));
    unset(table);
    component.outputs(0);
    if (!are_outputs_set(table)) return declares_wrong;
    component.derivatives();
    if (!are_derivatives_set(table)) return declares_wrong;

    component.reset();
    const Tracer<C> traced;
    print({name, C<double>::summary, C<double>::reference, detail::is_differentiable<C<double>>, table,
           traced.dependencies, traced.at_start});
    return 0;
}

}  // namespace adcs
