// What a component may have beside its variables, and what that has to look like. A function of a name that is called
// by nobody, as its arguments are others, would be a law that is silently left out: it is refused, in words.
#pragma once

#include <cstdint>
#include <type_traits>
#include <utility>

#include "fmi/declaration.hpp"

namespace adcs::detail {

template <class C, class = void>
constexpr bool has_declare = false;
template <class C>
constexpr bool has_declare<C, std::void_t<decltype(std::declval<C&>().declare(std::declval<Declare<double>&>()))>> =
    true;
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
constexpr bool has_sample<C, std::void_t<decltype(std::declval<C&>().sample(std::declval<const Sample&>()))>> = true;
template <class C, class = void>
constexpr bool has_events = false;
template <class C>
constexpr bool has_events<C, std::void_t<decltype(std::declval<C&>().events(std::declval<const Events&>()))>> = true;
template <class C, class = void>
constexpr bool has_validate = false;
template <class C>
constexpr bool has_validate<C, std::void_t<decltype(std::declval<const C&>().validate(std::declval<Words&>()))>> = true;
/// What is said into a copy is said to nobody.
template <class C, class = void>
constexpr bool validates_a_copy = false;
template <class C>
constexpr bool validates_a_copy<C, std::void_t<decltype(std::declval<const C&>().validate(std::declval<Words>()))>> =
    true;
template <class C, class = void>
constexpr bool has_stream = false;
template <class C>
constexpr bool has_stream<C, std::void_t<decltype(C::stream)>> = true;
template <class C, class = void>
constexpr bool has_summary = false;
template <class C>
constexpr bool has_summary<C, std::void_t<decltype(*&C::summary)>> =
    std::is_convertible_v<decltype(*&C::summary), const char*>;
template <class C, class = void>
constexpr bool has_reference = false;
template <class C>
constexpr bool has_reference<C, std::void_t<decltype(*&C::reference)>> =
    std::is_convertible_v<decltype(*&C::reference), const char*>;
template <class C, class = void>
constexpr bool is_differentiable = true;
template <class C>
constexpr bool is_differentiable<C, std::void_t<decltype(C::differentiable)>> = C::differentiable;

/// Beside another member of each name, that of C makes the name ambiguous, whatever it is: a function of any arguments,
/// a template, a private one.
struct Others {
    int outputs, derivatives, sample, sample_times, events, validate;
};
template <class C>
struct Both : C, Others {};
template <class C, class = void>
constexpr bool names_outputs = true;
template <class C>
constexpr bool names_outputs<C, std::void_t<decltype(&Both<C>::outputs)>> = false;
template <class C, class = void>
constexpr bool names_derivatives = true;
template <class C>
constexpr bool names_derivatives<C, std::void_t<decltype(&Both<C>::derivatives)>> = false;
template <class C, class = void>
constexpr bool names_sample = true;
template <class C>
constexpr bool names_sample<C, std::void_t<decltype(&Both<C>::sample)>> = false;
template <class C, class = void>
constexpr bool names_sample_times = true;
template <class C>
constexpr bool names_sample_times<C, std::void_t<decltype(&Both<C>::sample_times)>> = false;
template <class C, class = void>
constexpr bool names_events = true;
template <class C>
constexpr bool names_events<C, std::void_t<decltype(&Both<C>::events)>> = false;
template <class C, class = void>
constexpr bool names_validate = true;
template <class C>
constexpr bool names_validate<C, std::void_t<decltype(&Both<C>::validate)>> = false;

/// Refuses a component whose functions would not be called. Each text begins with the name that it is about.
template <class C>
constexpr bool is_well_formed() {
    static_assert(has_declare<C>,
                  "declare() has to be public and take whoever asks (template <class V> void declare(V& v))");
    static_assert(has_outputs<C> || !names_outputs<C>,
                  "outputs() has to be public and without arguments (void outputs())");
    static_assert(has_derivatives<C> || !names_derivatives<C>,
                  "derivatives() has to be public and without arguments (void derivatives())");
    static_assert(has_sample<C> || !names_sample<C>,
                  "sample() has to be public and take the sample (void sample(const Sample& s))");
    static_assert(!names_sample_times<C>,
                  "sample_times() is called by nobody (v.sampled(period) in declare() says when to sample)");
    static_assert(has_events<C> || !names_events<C>,
                  "events() has to be public and take what happened (void events(const Events& e))");
    static_assert((has_validate<C> && !validates_a_copy<C>) || !names_validate<C>,
                  "validate() has to be public and const, and say what is wrong (void validate(Words& refuse) const)");
    static_assert(has_summary<C>,
                  "summary is missing: what the component is, in a line (static constexpr auto summary = \"...\";)");
    static_assert(has_reference<C>,
                  "reference is missing: where the law is from (static constexpr auto reference = \"\"; if nowhere)");
    if constexpr (has_outputs<C>) {
        static_assert(std::is_void_v<decltype(std::declval<C&>().outputs())>,
                      "outputs() returns a value that nobody takes: it sets the variables instead (void outputs())");
    }
    if constexpr (has_derivatives<C>) {
        static_assert(std::is_void_v<decltype(std::declval<C&>().derivatives())>,
                      "derivatives() returns a value that nobody takes: it sets the variables instead (void "
                      "derivatives())");
    }
    return true;
}

}  // namespace adcs::detail
