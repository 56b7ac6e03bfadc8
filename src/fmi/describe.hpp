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

/// These print what is wrong and return false. The last two of them are asked after what is to be set was unset, and the
/// function in question called.
bool is_declared_right(const Table& table, const Functions& has);
bool are_start_values_right(const Table& table);
bool are_outputs_set(const Table& table);
bool are_derivatives_set(const Table& table);

/// Gives outputs and derivatives values that no law computes. Where one stays, or comes of it, what a run gives depends
/// on what was called before.
void unset(const Table& table);

/// Before a function of the component is called: its name as the header has it, and what the variables are that it may
/// not set. is_kept() is asked after it.
void enter(const char* function, const Table& table);
bool is_kept(const Table& table);

/// Whether outputs and derivatives are as they were before: asked after functions were called once more, which may not
/// depend on how often that is done.
bool is_repeated(const Table& table);

/// Moves what the law is a function of a little away from the start values: what is multiplied shows where it is not 0.
void shift(const Table& table);

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
    if constexpr (detail::has_validate<C<double>>) {
        Words refused;
        component.component.validate(refused);
    }
    if (!is_declared_right(table, has) || !are_start_values_right(table)) return declares_wrong;
    for (const bool shifted : {false, true}) {
        if (shifted) shift(table);
        enter("sample()", table);
        component.sample(all_due(component.clocks(), 0, true));
        if (!is_kept(table)) return declares_wrong;
        unset(table);
        enter("outputs()", table);
        component.outputs(0);
        if (!is_kept(table) || !are_outputs_set(table)) return declares_wrong;
        enter("derivatives()", table);
        component.derivatives();
        if (!is_kept(table) || !are_derivatives_set(table)) return declares_wrong;
        enter(has.outputs ? "outputs()" : "derivatives()", table);
        component.outputs(0);
        component.derivatives();
        if (!is_repeated(table)) return declares_wrong;
        enter("events()", table);
        Words said;
        component.events({0, true, said});
        if (!is_kept(table)) return declares_wrong;
        component.reset();
    }
    enter("", table);
    const Tracer<C> traced;
    print({name, C<double>::summary, C<double>::reference, detail::is_differentiable<C<double>>, table,
           traced.dependencies, traced.at_start});
    return 0;
}

}  // namespace adcs
