"""Each usual mistake in a component's header ends in one line with its place, what is wrong, and the way out."""

import os
import re
import sys
from pathlib import Path

import pytest

import adcs
from adcs.cli import app
from fmus.build import describe
from fmus.checks.functions import offered
from fmus.code import without_comments
from tests.invoking import invoke
from tests.mock_header import mock_header

LAW = mock_header(
    "MyLaw",
    """\
    Vec3<T> omega{0.0, 0.0, 0.0}, torque{0.0, 0.0, 0.0};
    T k = 1.0;

    template <class V>
    void declare(V& v) {
        v.input("omega", omega, unit::rad_per_s, "rate");
        v.parameter("k", k, unit::N_m_s, "gain").above(0);
        v.output("torque", torque, unit::N_m, "torque");
    }

    void outputs() { torque = -k * omega; }
""",
    summary="a law",
    kind="controller",
)
BODY = "torque = -k * omega;"
OUTPUTS = "    void outputs() { torque = -k * omega; }"
MEMBER, DECLARED, SET = 15, 20, 24
"""The lines of k, of its declaration, and of outputs()."""
ELSEWHERE = "there is no {0} that"
EXPRESSED = f"(express it by {', '.join(offered())})"


def also(member: str, declared: str, body: str = "") -> list[tuple[str, str]]:
    """Return the changes that bring one more variable, and what outputs() does with it."""
    modes = 'static constexpr const char* modes[] = {"off", "on"};'
    return [
        ("T k = 1.0;", f"T k = 1.0; {modes} {member}"),
        ('v.parameter("k"', f'{declared} v.parameter("k"'),
        (BODY, f"{BODY} {body}"),
    ]


def described(folder: Path, *changes: tuple[str, str]) -> str:
    """Return what is said of the law with these changes, from the line on."""
    text = LAW
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    header = folder / "my_law.hpp"
    header.write_text(text)
    with pytest.raises(adcs.AdcsError) as refused:
        describe(str(header))
    said, _, log = str(refused.value).partition("; the compiler's full output: ")
    assert "\n" not in str(refused.value)
    assert not log or "error" in Path(log).read_text()
    assert said.startswith(f"{header}:"), said
    return said.removeprefix(f"{header}:")


@pytest.mark.parametrize(
    ("line", "said", "changes"),
    [
        # types
        (DECLARED, "a variable of another type than T, such as double, carries", [("T k", "double k")]),
        (22, "a vector or matrix of another type than T carries no derivatives (write Vec3<T>", [
            ("Vec3<T> omega{0.0, 0.0, 0.0}, torque", "Vec3<T> omega{0.0, 0.0, 0.0};\n Vec3<double> torque")]),
        (DECLARED, "a matrix has a fixed size, in rows as FMI has them (write Mat3<T>", [
            ("T k = 1.0", "Eigen::Matrix<T, 2, 2> k")]),
        (SET, "a number of type T is put into double, which carries no derivatives (write T; value_of(x) is the", [
            (BODY, "double x = k; torque = -x * omega;")]),
        (SET, "a number of type T is no condition (compare it: x > 0.0, x == y)", [(BODY, "if (k) torque = omega;")]),
        (SET, "a Vec3<double> is assigned to a single number (take one of it: x(0), x.norm() or", [
            (BODY, "k = omega;")]),
        (SET, "the two sides of = are of different kinds (Vec3<T>::Constant(x)", [(BODY, "torque = k;")]),
        (SET, "vectors or matrices of sizes that do not fit are put together", [
            (BODY, "torque = Quat<T>{1.0, 0.0, 0.0, 0.0};")]),
        (14, "a vector has another number of elements than is given", [("omega{0.0, 0.0, 0.0}", "omega{0.0, 0.0}")]),
        (SET, "two vectors are multiplied by * (write a.dot(b), a.cross(b) or", [(BODY, "torque = omega * omega;")]),
        (SET, "cross() does not take these arguments", [(BODY, "torque = omega.cross(k);")]),
        (SET, "a Vec3<double> is put into a single number (take one of it: x(0), x.norm()", [
            (BODY, "T x = omega; torque = x * omega;")]),
        (14, "a single number is put into a Vec3<T> (write Vec3<T>::Constant(x), or all of them", [
            ("omega{0.0, 0.0, 0.0}", "omega = 0.0")]),
        (SET, "numbers of type T are put into double, which carries no derivatives (write T)", [
            (BODY, "Vec3<double> x = omega; torque = x;")]),
        (SET, "an operator stands between what it is not for, such as a vector and a number", [
            (BODY, "torque = omega + k;")]),
        (SET, "what stands before and behind : is of different types (Vec3<T>::Zero()", [
            (BODY, "torque = k > 0.0 ? omega : 0.0;")]),
        (MEMBER, "a text stands where a number belongs (leave the quotes out)", [("T k = 1.0", 'T k = "1"')]),
        (DECLARED, "a text stands where a number belongs (leave the quotes out)", [("above(0)", 'above("0")')]),
        (14, "Vec3 is a template (write Vec3<T>)", [("Vec3<T>", "Vec3")]),
        (DECLARED, "k starts at 0, which is not above 0 (it starts at what is behind its name)", [("k = 1.0", "k")]),
        (19, "omega has no start value (write one behind its name, as in Vec3<T> x{0.0, 0.0, 0.0})", [
            ("omega{0.0, 0.0, 0.0}", "omega")]),
        (19, "omega has norm 0: a unit vector is expected (it starts at what is behind its name)", [
            ('"rate")', '"rate").unit_vectors()')]),
        (SET, "x has no value where it is used (give it one: T x = 0.0;)", [(BODY, "T x; torque = x * omega;")]),
        (SET, "1 / 2 is a whole number in C++ (write 1.0 / 2.0)", [(BODY, "torque = 1 / 2 * k * omega;")]),
        # words and signs
        (MEMBER, "a ';' is missing behind 1.0", [("T k = 1.0;", "T k = 1.0")]),
        (SET, "a ';' is missing behind omega", [(BODY, "torque = omega")]),
        (SET, "a ';' is missing behind omega (a comment begins with //)", [(BODY, "torque = omega  # a law\n;")]),
        (14, "a ';' is missing behind }, or one '}' there is too many", [
            ("};\n", "}};\n"), ("}, torque", "}; Vec3<T> torque")]),
        (SET, "a ')' or a ',' is missing behind omega", [(BODY, "torque = -(k * omega;")]),
        (19, "a ')' or a ',' is missing behind \"omega\"", [('"omega", omega', '"omega" omega')]),
        (19, 'a text has no end (a " is missing)', [('"rate")', '"rate)')]),
        (11, 'a text has no end (a " is missing)', [('"a law"', '"a law')]),
        (DECLARED, 'C++ has no “ (quotes are ")', [('"gain"', "“gain”")]),
        (23, "a '}' is missing before this function", [('"torque");\n    }', '"torque");')]),
        (6, "this '{' is closed nowhere (a '}' is missing)", [("}  // namespace adcs", "")]),
        (MEMBER, "a number has a point and no comma (1.0)", [("1.0", "1,0")]),
        (SET, "^ is no power in C++ (write x * x)", [(BODY, "torque = k^2 * omega;")]),
        (SET, "(** is no power in C++: write x * x)", [(BODY, "torque = k**2 * omega;")]),
        (SET, "[...] makes no vector in C++ (write {x, y, z})", [(BODY, "torque = [1, 2, 3];")]),
        (SET, "this is a pointer (leave `this.` out)", [(BODY, "this.torque = omega;")]),
        (25, "expected ';' after the struct, or a '}' inside it", [("};\n\n}", "}\n\n}")]),
        (MEMBER, "new is a word of C++ (take another name)", [("T k", "T new")]),
        (MEMBER, "M_PI is a macro of the C library (take another name)", [("T k", "T M_PI"), (", k, ", ", M_PI, ")]),
        (MEMBER, "T is what the template calls a type (take another name)", [("T k", "T T")]),
        (SET, "x is there already, in the header or in one of the project (take another name)", [
            (BODY, f"T x = k; T x = 1.0; {BODY}")]),
        (25, "it is there twice (leave one of them out)", [(OUTPUTS, f"{OUTPUTS}\n{OUTPUTS}")]),
        (MEMBER, "omega is there twice (take another name for one of them)", [("T k", "T omega, k")]),
        (SET, "the condition stands in brackets, as in if (x > 0.0)", [(BODY, "if k > 0.0 torque = omega;")]),
        (SET, "something is missing here, or too much behind &&", [(BODY, "if (k > 0.0 &&) torque = omega;")]),
        (8, "a '{' is missing before this", [("namespace adcs {", "namespace adcs")]),
        (2, "no such word stands behind # (#pragma once, #include)", [("#pragma", "#pragmas")]),
        (4, "the name of what is included stands in quotes", [
            ("#pragma once\n", "#pragma once\n\n#include gain.hpp\n")]),
        # names
        (9, "there is no `struct MyLaw`, but YourLaw; a component's struct has its file's name", [
            ("MyLaw", "YourLaw")]),
        (9, "a component is a struct, whose members are public (struct MyLaw)", [("struct", "class")]),
        (13, "T is not known here (template <class T> before struct MyLaw)", [("template <class T>\n", "")]),
        (18, "V is not known here (template <class V> before void declare(V& v))", [("template <class V>", "")]),
        (SET, "there is no x (T x = ...; makes a variable)", [(BODY, f"x = k; {BODY}")]),
        (19, "there is no input by itself (write v.input)", [("v.input", "input")]),
        (19, "-> is for pointers (write a point)", [("v.input", "v->input")]),
        (21, "there is no N_m (write unit::N_m)", [("unit::N_m,", "N_m,")]),
        (DECLARED, "unit is a namespace (two colons, as in unit::name)", [("unit::N_m_s", "unit.N_m_s")]),
        (DECLARED, "a declaration has no .min() (write .at_least())", [("above", "min")]),
        (SET, "there is no norm() by itself (a vector or matrix has it: x.norm())", [
            (BODY, "torque = norm(omega) * omega;")]),
        (SET, "a vector or matrix has no .dott (did you mean .dot?)", [(BODY, "torque = omega.dott(omega) * omega;")]),
        (SET, "a function is named and not called (brackets, as in x.norm())", [
            (BODY, "torque = omega.norm * omega;")]),
        (SET, "a function is used as a number (the time is a variable: T time = 0.0; and", [
            (BODY, "torque = time * omega;")]),
        (SET, "there is no omgea (did you mean omega?)", [(BODY, "torque = -k * omgea;")]),
        (DECLARED, "there is no unit::N_mm (did you mean unit::N_m or unit::N_m_s?)", [
            ("N_m_s", "N_mm")]),
        (DECLARED, 'v.parameter does not take these arguments (it takes "name", variable, unit::...', [
            ("unit::N_m_s", '"N.m.s"')]),
        (DECLARED, "a declaration has no v.param (did you mean v.parameter?)", [("v.parameter", "v.param")]),
        (DECLARED, "a declaration has no .at_lest() (did you mean .at_least", [("above", "at_lest")]),
        (21, "variable torque is declared twice (give one of them another name)", [('"k"', '"torque"')]),
        (DECLARED, "'k gain' is no name of a variable (letters, digits and underscores)", [('"k"', '"k gain"')]),
        (DECLARED, "a seed is a whole number (write std::int32_t)", [
            ('v.parameter("k", k, unit::N_m_s, "gain").above(0)', 'v.seed("k", k, "seed")')]),
        (4, "there is no fmi/declarations.hpp to include (did you mean fmi/declaration.hpp", [
            ("declaration.hpp", "declarations.hpp")]),
        (9, "MyLaw is no template of its scalar type (template <class T> struct MyLaw)", [
            ("template <class T>\n", "using T = double;\n")]),
        (13, "Vec3 is not known here (namespace adcs { ... } has to be around the struct)", [
            ("namespace adcs {\n", ""), ("}  // namespace adcs\n", "")]),
        # what is no number
        (DECLARED, "a variable of another type than T, such as double, carries no derivatives (write T, Vec3<T>, "
         "Quat<T> or Mat3<T>; a bool or std::int32_t has no unit)", [("T k = 1.0", "bool k = true")]),
        (DECLARED, "outputs() does not set on, or reads it before it does (set all of it, each time)",
         also("bool on = false;", 'v.output("on", on, "is on");')),
        (DECLARED, "outputs() does not set n, or reads it before it does (set all of it, each time)",
         also("std::int32_t n = 0;", 'v.output("n", n, "how many");')),
        (DECLARED, "outputs() does not set says, or reads it before it does (set all of it, each time)",
         also("const char* says = nullptr;", 'v.output("says", says, "words");', "says = nullptr;")),
        (DECLARED, "says is a text, which is not held (leave .sampled() out)",
         also('const char* says = "";', 'v.sampled(k); v.output("says", says, "words").sampled();', 'says = "";')),
        (DECLARED, "mode starts at a number that none of its items has (the first is 0)",
         also("std::int32_t mode = 2;", 'v.input("mode", mode, modes, "what it does");')),
        (DECLARED, "an item of mode is no name (letters, digits and underscores)",
         [*also("std::int32_t mode = 0;", 'v.input("mode", mode, modes, "what it does");'), ('"off"', '"not on"')]),
        (DECLARED, "two items of mode have the same name (give one of them another)",
         [*also("std::int32_t mode = 0;", 'v.input("mode", mode, modes, "what it does");'), ('"off"', '"on"')]),
        (DECLARED, "on is no vector or matrix, of which alone such a condition can be",
         also("bool on = false;", 'v.input("on", on, "is on").unit_vectors();')),
        (DECLARED, "the nominal value of k has to be above 0 (how large it usually is)", [("above(0)", "nominal(0)")]),
        # functions
        (SET, "outputs() gives another torque when it is called again (what keeps a value is a v.state or v.held)", [
            ("T k = 1.0", "T last = 0.0; T k = 1.0"), (BODY, "torque = last * omega; last = k;")]),
        (SET, "outputs() gives another torque when it is called again", [(BODY, "torque = rand() * omega;")]),
        (SET, "an array has no element 3 (they are counted from 0)", [(BODY, "T a[3]{}; torque = a[3] * omega;")]),
        (SET, "outputs() puts another number of elements into a vector or matrix than it has", [
            (BODY, "torque = Mat3<T>{{1.0, 0.0, 0.0}, {0.0, 1.0}, {0.0, 0.0, 1.0}} * omega;")]),
        (SET, "a number of type T is put into double, which carries no", [
            (BODY, "double n = omega.norm(); torque = n * omega;")]),
        (SET, "sin() does not take these arguments (write sin(x), of numbers; an element of v is v(0))", [
            (BODY, "torque = sin(omega);")]),
        (SET, "outputs() takes an element that a vector of 3 does not have (they are counted from 0)", [
            (BODY, "torque = -k * omega * omega[5];")]),
        (SET, "outputs() takes an element that a vector of 3 does not have", [
            (BODY, "torque = omega; torque(3) = k;")]),
        (SET, "outputs() takes an element that a matrix of 3 x 3 does not have", [
            (BODY, "torque = Mat3<T>::Identity().eval()(3, 0) * omega;")]),
        (SET, "outputs() puts another number of elements into a vector or matrix than it has", [
            (BODY, "torque << 1.0, 2.0;")]),
        (SET, "outputs() changes the input omega (compute into a variable of its own", [
            (BODY, f"omega *= 0.5; {BODY}")]),
        (SET, "outputs() changes the parameter k (compute into a variable of its own", [(BODY, f"k *= 2.0; {BODY}")]),
        (25, "derivatives() changes the state x (compute into a variable of its own", [
            ('v.output("torque"', 'v.state("x", x, xDot, unit::one, "x");\nv.output("torque"'),
            ("T k = 1.0", "T x = 1.0, xDot = 0.0, k = 1.0"),
            (OUTPUTS, f"{OUTPUTS}  void derivatives() {{ xDot = -x; x = 0.0; }}")]),
        (25, "sample() changes the input omega (compute into a variable of its own", [
            ('v.output("torque"', 'v.sampled(k); v.output("torque"'),
            (OUTPUTS, f"{OUTPUTS}\n    void sample(const Sample&) {{ omega.setZero(); }}")]),
        (25, "events() changes the parameter k (compute into a variable of its own", [
            ('v.output("torque"', 'v.event("e", e, unit::one, "e"); v.output("torque"'),
            ("T k = 1.0", "T e = 0.0, k = 1.0"),
            (OUTPUTS, "    void outputs() { torque = -k * omega; e = k; }\n"
                      "    void events(const Events&) { k = 2.0; }")]),
        (25, "events() has to be public and take what happened (void events(const Events& e))", [
            (OUTPUTS, f"{OUTPUTS}\n    void events() {{}}")]),
        (25, "events() is called at nothing (v.event(...) in declare(), or a held time with .wakes())", [
            (OUTPUTS, f"{OUTPUTS}\n    void events(const Events&) {{}}")]),
        (21, "nothing happens at e (write void events(const Events& e))", [
            ('v.output("torque"', 'v.event("e", e, unit::one, "e"); v.output("torque"'),
            ("T k = 1.0", "T e = 0.0, k = 1.0"),
            (BODY, f"{BODY} e = k;")]),
        (SET, "std::min knows nothing of numbers of type T (write min(x, y))", [
            (BODY, "torque = std::min(k, 1.0) * omega;")]),
        (SET, "std::abs knows nothing of numbers of type T (write abs(x))", [(BODY, "torque = std::abs(k) * omega;")]),
        (SET, "a type is missing (void before a function; T or Vec3<T> before a variable)", [
            ("void outputs", "outputs")]),
        (SET, "a function that returns something ends without it (write return ...;)", [
            (OUTPUTS, f"{OUTPUTS[:-1]}; torque *= f(); }} T f() {{ }}")]),
        (19, "declare() has to be public and take whoever asks (template <class V> void declare(V& v))", [
            ("    template <class V>", "private:\n    template <class V>")]),
        (17, "auto is no type of an argument (template <class V> before the function, and V for auto)", [
            ("    template <class V>\n    void declare(V& v)", "    void declare(auto& v)")]),
        (19, "declare() takes whoever asks as what is not const (template <class V> void declare(V& v))", [
            ("(V& v)", "(const V& v)")]),
        (9, "MyLaw has a constructor of its own (leave it out", [("T k = 1.0;", "T k = 1.0; MyLaw(T x) : k(x) {}")]),
        (MEMBER, "k is static, and all instances of a component would share it (leave `static` out)", [
            ("T k = 1.0", "static T k")]),
        (MEMBER, "f is a function that does nothing yet (write its body", [
            ("T k = 1.0;", "T k = 1.0; void f();"), (BODY, f"f(); {BODY}")]),
        (12, "reference is missing: where the law is from", [('reference = ""', "reference = 0")]),
        (SET, f"a number of type T is handed to std::erf, which rounds differently on each platform {EXPRESSED}", [
            (BODY, "torque = std::erf(k) * omega;")]),
        (SET, "a number of type T is handed to std::sin, which rounds differently on each platform (write sin(x))", [
            (BODY, "torque = std::sin(k) * omega;")]),
        (SET, "a number of type T is handed to std::pow, which rounds differently on each platform (write pow(x, y))", [
            (BODY, "torque = std::pow(k, 2) * omega;")]),
        (SET, "std::max knows nothing of numbers of type T (write max(x, y))", [
            (BODY, "torque = std::max(0.0, k) * omega;")]),
        (SET, "tan() does not take these arguments (write tan(x), of numbers; an element of v is v(0))", [
            (BODY, "torque = tan(omega);")]),
        (21, "nothing sets the output torque (write void outputs())", [(OUTPUTS, "")]),
        (21, "nothing sets the output torque (write void outputs())", [("void outputs", "void output")]),
        (21, "outputs() does not set torque, or reads it before it does (set all of it, each time)", [(BODY, "")]),
        (21, "outputs() does not set torque, or reads it before it does", [(BODY, "torque(0) = k;")]),
        (21, "outputs() does not set torque, or reads it before it does", [(BODY, "torque += omega;")]),
        (SET, "outputs() has to be public and without arguments", [("outputs()", "outputs(double t)")]),
        (25, "outputs() has to be public and without arguments", [(OUTPUTS, f"private:\n{OUTPUTS}")]),
        (SET, "outputs() returns a value that nobody takes: it sets the variables instead", [
            ("void outputs() { torque =", "Vec3<T> outputs() { return")]),
        (SET, "outputs() returns nothing (it sets the variables that are declared)", [(BODY, "return -k * omega;")]),
        (SET, "a variable is set in a function that is const (leave `const` out)", [("outputs()", "outputs() const")]),
        (DECLARED, "a variable is const, or declare() is, and all of them with it (leave `const` out)", [
            ("T k", "const T k")]),
        (19, "a variable is const, or declare() is, and all of them with it (leave `const` out)", [
            ("(V& v)", "(V& v) const")]),
        (9, "declare() takes visitors of one type only (template <class V> void declare(V& v))", [
            ("    template <class V>\n    void declare(V& v)", "    void declare(Declare<T>& v)")]),
        (18, "declares no output", [('v.output("torque", torque, unit::N_m, "torque");', "")]),
        (21, "nothing sets the derivative of torque (write void derivatives())", [
            ('v.output("torque", torque', 'v.state("torque", torque, omega'), (OUTPUTS, "")]),
        (21, "the derivative of x is not set, or read before it is", [
            ('v.output("torque"', 'v.state("x", x, xDot, unit::one, "x");\nv.output("torque"'),
            ("T k = 1.0", "T x = 0.0, xDot = 0.0, k = 1.0")]),
        (25, "derivatives() has no state to be of (v.state(...) in declare())", [
            (OUTPUTS, f"{OUTPUTS}\n    void derivatives() {{}}")]),
        (25, "sample() is called at times that nothing says (v.sampled(period) in declare())", [
            (OUTPUTS, f"{OUTPUTS}\n    void sample(const Sample&) {{}}")]),
        (25, "sample() has to be public and take the sample (void sample(const Sample& s))", [
            (OUTPUTS, f"{OUTPUTS}\n    void sample(std::int64_t k) {{}}")]),
        (25, "sample_times() is called by nobody (v.sampled(period) in declare() says when to sample)", [
            (OUTPUTS, f"{OUTPUTS}\n    int sample_times() const {{ return 0; }}")]),
        (21, "nothing is sampled at its times (void sample(const Sample& s), or an output with .sampled())", [
            ('v.output("torque"', 'v.sampled(k); v.output("torque"')]),
        (21, "torque is sampled by a clock that is not declared (v.sampled(period) in declare())", [
            ('"torque");', '"torque").sampled();')]),
        (20, "k is not what outputs() computes: only v.output(...) has .sampled()", [
            ('"gain")', '"gain").sampled()')]),
        (20, "k is not held: only v.held(...) has .output()", [('"gain")', '"gain").output()')]),
        (21, "torque is sampled by a clock that is not declared (v.sampled(period) in declare())", [
            ('v.output("torque"', 'v.sampled(k); v.output("torque"'), ('"torque");', '"torque").sampled(1);')]),
        (18, "too many: at most 96 variables with 1024 elements, 4 clocks and 32 event functions are possible", [
            ('v.output("torque"', 'for (int i = 0; i < 5; ++i) v.sampled(k);\nv.output("torque"'),
            (OUTPUTS, f"{OUTPUTS}\n    void sample(const Sample&) {{}}")]),
        (25, "validate() has to be public and const, and say what is wrong (void validate(Words& refuse) const)", [
            (OUTPUTS, f"{OUTPUTS}\n    bool validate() const {{ return true; }}")]),
        (25, "validate() has to be public and const, and say what is wrong (void validate(Words& refuse) const)", [
            (OUTPUTS, f"{OUTPUTS}\n    void validate(Words refuse) const {{ refuse(\"no\"); }}")]),
        (25, "a text with % takes other values than it is given", [
            (OUTPUTS, f"{OUTPUTS}\n    void validate(Words& refuse) const {{ refuse(\"k = %g, %g\", k); }}")]),
        (25, "a text with % takes other values than it is given", [
            (OUTPUTS, f"{OUTPUTS}\n    void validate(Words& refuse) const {{ refuse(\"k = %s\", k); }}")]),
        (DECLARED, "k cannot be inertia matrix: a matrix of 3 x 3, as Mat3<T> is, is expected", [
            (".above(0)", ".inertia()")]),
        (19, "omega cannot be unit quaternion: a vector of 4, as Quat<T> is, is expected", [
            ('"rate")', '"rate").unit_quaternion()')]),
        (DECLARED, "k cannot be increasing: a vector is expected", [(".above(0)", ".increasing()")]),
        (9, "summary is missing: what the component is, in a line", [("summary", "sumary")]),
        (10, "auto is for what is static (write static constexpr auto, or the type)", [
            ("static constexpr auto kind", "auto kind")]),
        # what FMUs do without
        (SET, "laws print nothing (what is to be seen of a law is an output: v.output(...) in", [
            (BODY, f"std::cout << 1.0; {BODY}")]),
        (25, "laws print nothing (what is to be seen of a law is an output", [
            ("#pragma once", "#pragma once\n#include <iostream>"), (BODY, f"std::cout << omega; {BODY}")]),
        (25, "laws print nothing (what is to be seen of a law is an output", [
            ("#pragma once", "#pragma once\n#include <iostream>"), (BODY, f"std::cout << 1.0; {BODY}")]),
        (9, "laws print nothing (what is to be seen of a law is an output", [
            (BODY, f'std::printf("%f", 1.0); {BODY}')]),
        (SET, "exceptions are not possible in an FMU (validate() refuses values)", [(BODY, "throw 1;")]),
        (15, "it needs operator new[](unsigned long), which FMUs do without (no std::string or", [
            ("T k", "double* more = new double[3]; T k")]),
        (15, "it needs std::string::~basic_string(), which FMUs do without (no std::string or", [
            ("T k", 'std::string name = "a name that is longer than what fits inside"; T k')]),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(tmp_path: Path, line: int, said: str, changes: list[tuple[str, str]]) -> None:
    where, _, words = described(tmp_path, *changes).partition(": ")
    assert said in words
    assert int(where) == line, words


def test_a_law_without_an_end_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules["fmus.describe"], "SECONDS", 1)  # fmus.describe is a function as well
    said = described(tmp_path, (BODY, f"while (k > 0.0) {BODY}"))
    assert said == "9: its law does not end within 1 s (a loop without an end?)"


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_a_law_that_ends_the_process_is_told(tmp_path: Path) -> None:
    said = described(tmp_path, (BODY, f"volatile int* none = nullptr; *none = 1; {BODY}"))
    assert said.startswith("9: its law ends the process: SIG"), said


def test_an_unchanged_law_is_none_of_these(tmp_path: Path) -> None:
    (tmp_path / "my_law.hpp").write_text(LAW.replace(BODY, "torque = 4 / 2 * std::min<T>(k, 1.0) * omega / 3;"))
    assert describe(str(tmp_path / "my_law.hpp")).name == "MyLaw"


def test_all_that_the_compiler_said_is_in_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "my_law.hpp").write_text(LAW.replace("T k", "double k"))
    monkeypatch.chdir(tmp_path)
    for arguments in (["build", "my_law.hpp"], ["run", "my_law.hpp"], ["info", "my_law.hpp"]):
        said = str(invoke(app.app, arguments).exception)
        assert said.startswith("my_law.hpp:20: a variable of another type than T, such as double, carries no deriv")
        whole = Path(said.rpartition(" the compiler's full output: ")[2]).read_text()
        assert whole.count("\n") > 20 and "my_law.hpp:20:11: note: in instantiation of" in whole
        assert "\n" not in said
    assert [path.name for path in tmp_path.iterdir()] == ["my_law.hpp"]


def test_a_mistake_in_what_is_included_is_told_where_it_is(tmp_path: Path) -> None:
    (tmp_path / "gain.hpp").write_text("#pragma once\n\nnamespace adcs { constexpr double gain = 3.0 }\n")
    header = tmp_path / "my_law.hpp"
    header.write_text(LAW.replace("#pragma once\n", '#pragma once\n#include "gain.hpp"\n'))
    with pytest.raises(adcs.AdcsError, match=rf"^{re.escape(str(tmp_path))}/gain\.hpp:3: a ';' is missing behind 3.0"):
        describe(str(header))


def test_a_header_that_includes_nothing_is_refused(tmp_path: Path) -> None:
    """The precompiled headers would hide it here, and not where somebody compiles the sources in the FMU."""
    header = tmp_path / "my_law.hpp"
    header.write_text(LAW.replace('#include "fmi/declaration.hpp"\n', ""))
    with pytest.raises(
        adcs.AdcsError, match=r'includes nothing that a component is made of: #include "fmi/declaration'
    ):
        describe(str(header))


def test_a_header_without_a_kind_is_told_once_as_what_it_is_taken(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    header = tmp_path / "my_law.hpp"
    header.write_text(LAW.replace('    static constexpr auto kind = "controller";\n', ""))
    for _ in range(2):
        describe(str(header))
    said = [record.message for record in caplog.records if "says no kind" in record.message]
    assert said == [
        f'{header} says no kind and is taken for a controller: static constexpr auto kind = "sensor"; is another'
    ]


def test_comments_are_blank_and_texts_stay() -> None:
    code = 'a; // b\n"// c"; /* d\ne */ f'
    assert without_comments(code) == 'a;     \n"// c";     \n     f'


def test_functions_of_the_c_library_are_found_in_sources_and_where_they_are_not_seen_there(tmp_path: Path) -> None:
    header = tmp_path / "my_law.hpp"
    called = "torque = -(::sin(value_of(k)) + erf(value_of(k))) * omega;  // not std::cos"
    header.write_text(LAW.replace(BODY + " }", f"{called}\n    }}"))
    first = "MyLaw.fmu: "
    assert [(f.rule, f.message) for f in adcs.check(header) if f.message.startswith(first)] == [
        ("sources", f"{first}sources/my_law.hpp:24: ::sin, which rounds differently on each platform (write sin(x))"),
        ("sources", f"{first}its binary calls erf, which rounds differently on each platform {EXPRESSED}"),
    ]
