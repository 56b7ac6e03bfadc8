// Host tool: prints what declare() says as JSON, from which the XML and the documentation are made. It prints as it
// goes and needs nothing of the C++ runtime library, which would take longer to build than all components together.
#include "fmi/describe.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "fmi/conditions.hpp"
#include "fmi/instance.hpp"
#include "fmi/token.hpp"
#include "fmi/values.hpp"

namespace {

using namespace adcs;

void print_text(const char* text) {
    std::putchar('"');
    for (; *text != '\0'; ++text) {
        if (*text == '"' || *text == '\\') std::putchar('\\');
        std::putchar(*text);
    }
    std::putchar('"');
}

void print_number(double x) {
    if (std::isfinite(x)) {
        std::printf("%.17g", x);
    } else {
        std::printf("null");
    }
}

void print_key(const char* key) { std::printf(", \"%s\": ", key); }

void print_field(const char* key, const char* text) {
    print_key(key);
    if (text != nullptr) {
        print_text(text);
    } else {
        std::printf("null");
    }
}

void print_field(const char* key, double number) {
    print_key(key);
    print_number(number);
}

/// "[a, b, ...]" of n items.
template <class PrintItem>
void print_list(std::size_t n, PrintItem print_item) {
    std::putchar('[');
    for (std::size_t i = 0; i < n; ++i) {
        if (i > 0) std::printf(", ");
        print_item(i);
    }
    std::putchar(']');
}

const char* causality(const Variable& v) {
    constexpr const char* names[] = {"independent", "parameter", "input", "output", "local"};
    return names[static_cast<int>(v.causality)];
}

const char* variability(const Variable& v) {
    constexpr const char* names[] = {"fixed", "tunable", "discrete", "continuous"};
    return names[static_cast<int>(v.variability)];
}

bool has_start(const Variable& v) {
    return v.causality == Causality::parameter || v.causality == Causality::input || v.role == Role::state;
}

const char* initial(const Variable& v) {
    if (v.causality == Causality::independent || v.causality == Causality::input) return nullptr;
    return has_start(v) ? "exact" : "calculated";
}

void print_shape(const Variable& v) {
    const std::uint32_t extents[] = {v.rows, v.cols};
    const std::size_t dimensions = v.rows == 0 ? 0 : v.cols == 0 ? 1 : 2;
    print_list(dimensions, [&](std::size_t i) { std::printf("%u", extents[i]); });
}

const char* type(const Variable& v) {
    constexpr const char* names[] = {"Float64", "Int32", "Boolean", "Enumeration", "String"};
    return names[static_cast<int>(v.type)];
}

/// The items of an enumeration; nothing of another variable.
void print_items(const Variable& v) {
    print_list(v.n_items, [&](std::size_t i) { print_text(v.items[i]); });
}

void print_start(const Variable& v) {
    if (!has_start(v)) {
        std::printf("null");
        return;
    }
    print_list(v.size, [&](std::size_t i) { print_number(number_of<double>(v, static_cast<std::uint32_t>(i))); });
}

/// Whether an unknown depends on element e of a known. What is normalised at initialization depends on all elements of it.
bool depends(const Bits& unknown, const Variable& known, std::uint32_t e, bool at_initialization) {
    const bool start_value = known.causality == Causality::parameter || known.role == Role::state;
    if (!at_initialization || !start_value || !is_normalised(known.kind)) return unknown.set[known.vr + e];
    for (std::uint32_t other = 0; other < known.size; ++other) {
        if (unknown.set[known.vr + other]) return true;
    }
    return false;
}

/// Per element the value references it depends on: of time, inputs, continuous states and parameters.
void print_dependencies(const Table& table, const Dependencies& found, const Variable& v, bool at_initialization) {
    if ((v.causality != Causality::output && v.role != Role::derivative && v.role != Role::event) ||
        (at_initialization && v.role == Role::state)) {
        std::printf("null");
        return;
    }
    print_list(v.size, [&](std::size_t i) {
        bool first = true;
        std::putchar('[');
        for (const Variable& k : table) {
            for (std::uint32_t e = 0; e < k.size; ++e) {
                if (!depends(found[v.vr + i], k, e, at_initialization)) continue;
                std::printf(first ? "%u" : ", %u", k.vr + e);
                first = false;
            }
        }
        std::putchar(']');
    });
}

void print_variable(const Table& table, const Dependencies& found, const Dependencies& at_start, const Variable& v) {
    const bool is_derivative = v.role == Role::derivative;
    char text[128];
    std::printf("{\"name\": ");
    std::snprintf(text, sizeof text, is_derivative ? "der(%s)" : "%s", v.name);
    print_text(text);
    print_field("vr", v.vr);
    print_key("shape");
    print_shape(v);
    print_field("type", type(v));
    print_key("items");
    print_items(v);
    print_field("causality", causality(v));
    print_field("variability", variability(v));
    print_field("initial", initial(v));
    const UnitOf unit(v);
    print_field("unit", v.type == Type::float64 ? unit->name : nullptr);
    print_field("display_unit", unit->display);
    print_key("start");
    print_start(v);
    print_field("min", std::fmax(v.above, v.min));
    print_key("min_excluded");
    std::printf(std::isfinite(v.above) ? "true" : "false");
    print_field("max", v.max);
    print_field("condition", condition(v.kind));
    print_field("nominal", v.nominal == 1.0 ? std::nan("") : v.nominal);
    std::snprintf(text, sizeof text, "time derivative of %s", v.name);
    print_field("description", is_derivative ? text : v.description);
    print_key("is_event");
    std::printf(v.role == Role::event ? "true" : "false");
    print_key("is_seed");
    std::printf(v.role == Role::seed ? "true" : "false");
    print_field("derivative_of", is_derivative ? table.variables[v.derivative_of].vr : std::nan(""));
    print_key("dependencies");
    print_dependencies(table, found, v, false);
    print_key("initial_dependencies");
    print_dependencies(table, at_start, v, true);
    std::putchar('}');
}

void print_unit(const Unit& u) {
    constexpr const char* bases[] = {"kg", "m", "s", "A", "K", "rad"};
    const Dimension& d = u.dimension;
    const int exponents[] = {d.kg, d.m, d.s, d.A, d.K, d.rad};
    std::printf("{\"name\": ");
    print_text(u.name);
    print_key("exponents");
    const char* separator = "{";
    for (std::size_t i = 0; i < std::size(bases); ++i) {
        if (exponents[i] == 0) continue;
        std::printf("%s\"%s\": %d", separator, bases[i], exponents[i]);
        separator = ", ";
    }
    std::printf(*separator == '{' ? "{}" : "}");
    print_field("factor", d.factor);
    std::printf(", \"offset\": 0.0");
    print_key("display");
    print_list(u.display != nullptr ? 1 : 0, [&](std::size_t) {
        std::printf("{\"name\": ");
        print_text(u.display);
        print_field("factor", u.display_factor);
        std::putchar('}');
    });
    std::putchar('}');
}

/// The first variable with a unit of this name.
const Variable& first_with(const Table& table, const char* unit) {
    const Variable* v = table.begin();
    while (v->type != Type::float64 || std::strcmp(UnitOf(*v)->name, unit) != 0) ++v;
    return *v;
}

/// Whether no variable before v has its unit.
bool introduces_unit(const Table& table, const Variable& v) {
    return v.type == Type::float64 && &first_with(table, UnitOf(v)->name) == &v;
}

bool is_same(const char* a, const char* b) {
    return a == b || (a != nullptr && b != nullptr && std::strcmp(a, b) == 0);
}

bool is_same(const Unit& a, const Unit& b) {
    const Dimension &x = a.dimension, &y = b.dimension;
    return x.kg == y.kg && x.m == y.m && x.s == y.s && x.A == y.A && x.K == y.K && x.rad == y.rad &&
           x.factor == y.factor && is_same(a.display, b.display) && a.display_factor == b.display_factor;
}

bool refuse(const Variable& v, const char* before, const char* after) {
    std::fprintf(stderr, "\"%s\"\t%s%s%s\n", v.name, before, v.name, after);
    return false;
}

bool refuse(const char* found_by, const char* words) {
    std::fprintf(stderr, "%s\t%s\n", found_by, words);
    return false;
}

bool is_name(const char* name) {
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    if (!is_letter(*name)) return false;
    for (; *name != '\0'; ++name) {
        if (!is_letter(*name) && !is_digit(*name)) return false;
    }
    return true;
}

bool are_names_right(const Table& table) {
    for (const Variable& v : table) {
        if (v.role == Role::derivative) continue;  // goes by the state's name
        if (!(v.nominal > 0.0))
            return refuse(v, "the nominal value of ", " has to be above 0 (how large it usually is)");
        if (!is_name(v.name)) return refuse(v, "'", "' is no name of a variable (letters, digits and underscores)");
        for (const Variable* earlier = table.begin(); earlier != &v; ++earlier) {
            if (earlier->role != Role::derivative && std::strcmp(v.name, earlier->name) == 0)
                return refuse(v, "variable ", " is declared twice (give one of them another name)");
        }
    }
    return true;
}

/// Whether the items of an enumeration are names, each of which is there once, and it starts as one of them.
bool are_items_right(const Variable& v) {
    if (v.type != Type::enumeration) return true;
    for (std::uint32_t i = 0; i < v.n_items; ++i) {
        if (v.items[i] == nullptr || !is_name(v.items[i]))
            return refuse(v, "an item of ", " is no name (letters, digits and underscores)");
        for (std::uint32_t j = 0; j < i; ++j) {
            if (std::strcmp(v.items[i], v.items[j]) == 0)
                return refuse(v, "two items of ", " have the same name (give one of them another)");
        }
    }
    return is_item(v, number_of<double>(v, 0)) ||
           refuse(v, "", " starts at a number that none of its items has (the first is 0)");
}

bool are_units_right(const Table& table) {
    for (const Variable& v : table) {
        if (v.type != Type::float64) continue;
        const UnitOf unit(v);
        if (!unit->dimension.known)
            return refuse(v, "the unit of ", " has a name of unknown symbols (say its exponents beside it)");
        if (!is_same(*unit, *UnitOf(first_with(table, unit->name))))
            return refuse(v, "the unit of ", " has the name of another one (give it a name of its own)");
    }
    return true;
}

/// What only has sense for a variable of one shape; nullptr for any.
const char* shape_of(Kind kind) {
    switch (kind) {
        case Kind::unit_quaternion:
            return "a vector of 4, as Quat<T> is,";
        case Kind::inertia:
        case Kind::positive_definite:
        case Kind::positive_semidefinite:
        case Kind::rotation:
            return "a matrix of 3 x 3, as Mat3<T> is,";
        case Kind::increasing:
            return "a vector";
        default:
            return nullptr;
    }
}

bool has_shape(const Variable& v) {
    if (v.kind == Kind::unit_quaternion) return v.rows == 4 && v.cols == 0;
    if (v.kind == Kind::increasing) return v.rows != 0 && v.cols == 0;
    return v.rows == 3 && v.cols == 3;
}

/// Whether outputs() sets it.
bool is_of_outputs(const Variable& v) {
    return (v.role == Role::plain && v.causality == Causality::output) || v.role == Role::event;
}

/// Whether each kind of variable has the function that sets it.
bool are_functions_there(const Table& table, const Functions& has) {
    bool outputs = false, states = false, samples = has.sample, events = false;
    for (const Variable& v : table) {
        if (v.wrong != nullptr) return refuse(v, "", v.wrong);
        if (v.type != Type::float64 && v.kind != Kind::any)
            return refuse(v, "", " is no vector or matrix, of which alone such a condition can be");
        if (!are_items_right(v)) return false;
        if (v.clock >= table.clocks)
            return refuse(v, "", " is sampled by a clock that is not declared (v.sampled(period) in declare())");
        samples = samples || v.clock >= 0;
        outputs = outputs || v.causality == Causality::output;
        states = states || v.role == Role::state;
        if (is_of_outputs(v) && !has.outputs) return refuse(v, "nothing sets the output ", " (write void outputs())");
        if (v.role == Role::held && !has.sample && !has.events)
            return refuse(v, "nothing sets ", ", which is held (write void sample(const Sample& s))");
        if ((v.role == Role::event || v.wakes) && !has.events)
            return refuse(v, "nothing happens at ", " (write void events(const Events& e))");
        events = events || v.role == Role::event || v.wakes;
        if (v.role != Role::state) continue;
        if (!has.derivatives && !has.outputs)
            return refuse(v, "nothing sets the derivative of ", " (write void derivatives())");
    }
    if (has.sample && table.clocks == 0)
        return refuse("sample(", "sample() is called at times that nothing says (v.sampled(period) in declare())");
    if (table.clocks != 0 && !samples)
        return refuse("sampled(",
                      "nothing is sampled at its times (void sample(const Sample& s), or an output with .sampled())");
    if (has.events && !events)
        return refuse("events(",
                      "events() is called at nothing (v.event(...) in declare(), or a held time with .wakes())");
    if (!outputs && !states) return refuse("declare(", "it declares no output (v.output(...) in declare())");
    if (!states && has.derivatives)
        return refuse("derivatives()", "derivatives() has no state to be of (v.state(...) in declare())");
    return true;
}

/// What no law computes: not a number, of bits of its own that arithmetic keeps but for the sign.
constexpr std::uint64_t unset_bits = 0x7ff8'5e70'0000'0000;

/// And what no law sets something else to: no item, no bool, no text.
constexpr std::int32_t unset_integer = -0x5e70'0000;
constexpr unsigned char unset_bool = 0x5e;
const char* const unset_text = "unset";

/// The function that runs.
const char* running = "";
double before[Table::scalar_capacity];  // room for values of all types

/// Prints by what the function that runs is found, and its name: "void outputs(", "outputs()".
void begin_line() {
    const int length = static_cast<int>(std::strcspn(running, ")"));
    if (length > 0) std::fprintf(stderr, "void %.*s", length, running);
    std::fprintf(stderr, "\t%s ", length > 0 ? running : "it");
}

/// What a variable is called if the function that runs may not set it; nullptr if it may.
const char* only_read(const Variable& v) {
    const bool events = std::strcmp(running, "events()") == 0;
    if (v.role == Role::state) return events ? nullptr : "the state ";
    if (v.role == Role::held) return events || std::strcmp(running, "sample()") == 0 ? nullptr : "the held ";
    switch (v.causality) {
        case Causality::independent:
            return "the ";
        case Causality::parameter:
            return "the parameter ";
        case Causality::input:
            return "the input ";
        default:
            return nullptr;
    }
}

/// Where the values of a variable are kept, and how many bytes they are.
struct Kept {
    explicit Kept(const Variable& v) : before(::before + v.vr), bytes(v.size * size_of(v.type)) {}
    static std::size_t size_of(Type type) {
        constexpr std::size_t sizes[] = {sizeof(double), sizeof(std::int32_t), sizeof(bool), sizeof(std::int32_t),
                                         sizeof(const char*)};
        return sizes[static_cast<int>(type)];
    }
    void* before;
    std::size_t bytes;
};

bool is_set(const Variable& v) {
    switch (v.type) {
        case Type::float64:
            for (std::uint32_t e = 0; e < v.size; ++e) {
                if (math::bits_of(static_cast<const double*>(v.data)[e]) << 1 == unset_bits << 1) return false;
            }
            return true;
        case Type::int32:
        case Type::enumeration:
            return *static_cast<const std::int32_t*>(v.data) != unset_integer;
        case Type::boolean:
            return *static_cast<const unsigned char*>(v.data) != unset_bool;
        case Type::string:
            return *static_cast<const char* const*>(v.data) != unset_text &&
                   *static_cast<const char* const*>(v.data) != nullptr;
    }
    return true;
}

void unset(const Variable& v) {
    switch (v.type) {
        case Type::float64:
            for (std::uint32_t e = 0; e < v.size; ++e)
                std::memcpy(static_cast<double*>(v.data) + e, &unset_bits, sizeof(double));
            return;
        case Type::int32:
        case Type::enumeration:
            *static_cast<std::int32_t*>(v.data) = unset_integer;
            return;
        case Type::boolean:
            *static_cast<unsigned char*>(v.data) = unset_bool;
            return;
        case Type::string:
            *static_cast<const char**>(v.data) = unset_text;
            return;
    }
}

}  // namespace

bool adcs::is_declared_right(const Table& table, const Functions& has) {
    if (table.overflow) {
        std::fprintf(stderr,
                     "declare(\ttoo many: at most %d variables with %u elements, %d clocks and %d event functions are "
                     "possible\n",
                     Table::capacity, Table::scalar_capacity, Clocks::capacity, Events::capacity);
        return false;
    }
    return are_names_right(table) && are_units_right(table) && are_functions_there(table, has);
}

bool adcs::are_start_values_right(const Table& table) {
    for (const Variable& v : table) {
        if (const char* shape = shape_of(v.kind); shape != nullptr && !has_shape(v)) {
            std::fprintf(stderr, "\"%s\"\t%s cannot be %s: %s is expected\n", v.name, v.name, condition(v.kind), shape);
            return false;
        }
        if (v.type != Type::float64 || !has_start(v)) continue;
        char fault[256];
        for (std::uint32_t e = 0; e < v.size; ++e) {
            const double x = static_cast<const double*>(v.data)[e];
            if (!std::isfinite(x))
                return refuse(v, "", " has no start value (write one behind its name, as in Vec3<T> x{0.0, 0.0, 0.0})");
            const bool above = x > v.above, in = x >= v.min && x <= v.max;
            if (above && in) continue;
            std::snprintf(fault, sizeof fault,
                          " starts at %g, which is not %s %g (it starts at what is behind its name)", x,
                          !above      ? "above"
                          : x < v.min ? "at least"
                                      : "at most",
                          !above      ? v.above
                          : x < v.min ? v.min
                                      : v.max);
            return refuse(v, "", fault);
        }
        if (!meets_condition(v, fault, sizeof fault)) {
            std::fprintf(stderr, "\"%s\"\t%s (it starts at what is behind its name)\n", v.name, fault);
            return false;
        }
    }
    return true;
}

void adcs::enter(const char* function, const Table& table) {
    running = function;
    for (const Variable& v : table) std::memcpy(Kept(v).before, v.data, Kept(v).bytes);
}

bool adcs::is_kept(const Table& table) {
    for (const Variable& v : table) {
        if (only_read(v) == nullptr || std::memcmp(Kept(v).before, v.data, Kept(v).bytes) == 0) continue;
        begin_line();
        std::fprintf(stderr, "changes %s%s (compute into a variable of its own, as in const Vec3<T> x = ...)\n",
                     only_read(v), v.name);
        return false;
    }
    return true;
}

bool adcs::is_repeated(const Table& table) {
    for (const Variable& v : table) {
        if ((!is_of_outputs(v) && v.role != Role::derivative) ||
            std::memcmp(Kept(v).before, v.data, Kept(v).bytes) == 0)
            continue;
        begin_line();
        std::fprintf(stderr, "gives another %s%s when it is called again (what keeps a value is a v.state or v.held)\n",
                     v.role == Role::derivative ? "derivative of " : "", v.name);
        return false;
    }
    return true;
}

void adcs::shift(const Table& table) {
    for (const Variable& v : table) {
        if (v.type != Type::float64 || only_read(v) == nullptr) continue;
        for (std::uint32_t e = 0; e < v.size; ++e) static_cast<double*>(v.data)[e] += 0.001;
    }
}

void adcs::refuse_call(const char* expected, const char* where) {
    int rows = 0, columns = 0;
    const char* of = std::strstr(where, "Derived = Eigen::Matrix<");
    if (of != nullptr) of = std::strchr(of, ',');
    const bool known = of != nullptr && std::sscanf(of, ", %d, %d", &rows, &columns) == 2;
    begin_line();
    if (std::strstr(where, "CommaInitializer") != nullptr || std::strstr(expected, "list_size") != nullptr) {
        std::fprintf(stderr, "puts another number of elements into a vector or matrix than it has\n");
    } else if (known && std::strstr(expected, ">= 0") != nullptr) {
        std::fprintf(stderr, "takes an element that a %s of %d", columns == 1 ? "vector" : "matrix", rows);
        if (columns != 1) std::fprintf(stderr, " x %d", columns);
        std::fprintf(stderr, " does not have (they are counted from 0)\n");
    } else {
        std::fprintf(stderr, "asks Eigen for what it cannot do: it expects %s\n", expected);
    }
    std::_Exit(declares_wrong);
}

void adcs::unset(const Table& table) {
    for (const Variable& v : table) {
        if (is_of_outputs(v) || v.role == Role::derivative) ::unset(v);
    }
}

bool adcs::are_outputs_set(const Table& table) {
    for (const Variable& v : table) {
        if (is_of_outputs(v) && !is_set(v))
            return refuse(v, "outputs() does not set ", ", or reads it before it does (set all of it, each time)");
    }
    return true;
}

bool adcs::are_derivatives_set(const Table& table) {
    for (const Variable& v : table) {
        if (v.role == Role::derivative && !is_set(v))
            return refuse(v, "the derivative of ", " is not set, or read before it is (set all of it, each time)");
    }
    return true;
}

void adcs::print(const Description& description) {
    const Table& table = description.table;
    Dependencies at_start = description.dependencies;
    for (std::size_t i = 0; i < at_start.size(); ++i) at_start[i] = at_start[i] + description.at_start[i];
    char token[40]{};
    make_token(description.name, table, token);

    std::printf("{\"name\": ");
    print_text(description.name);
    print_field("description", description.summary);
    print_field("reference", description.reference);
    print_field("token", token);
    print_key("differentiable");
    std::printf(description.differentiable ? "true" : "false");
    print_key("sampled");
    std::printf(table.clocks != 0 ? "true" : "false");
    std::uint32_t states = 0;
    for (const Variable& v : table) states += v.role == Role::state ? v.size : 0;
    print_field("states", states);
    print_key("log_categories");
    print_list(std::size(log_categories), [](std::size_t i) {
        std::printf("{\"name\": ");
        print_text(log_categories[i].name);
        print_field("description", log_categories[i].description);
        std::putchar('}');
    });
    print_key("units");
    const char* separator = "[\n ";
    for (const Variable& v : table) {
        if (!introduces_unit(table, v)) continue;
        std::printf("%s", separator);
        print_unit(*UnitOf(v));
        separator = ",\n ";
    }
    std::putchar(']');
    print_key("variables");
    print_list(static_cast<std::size_t>(table.count), [&](std::size_t i) {
        std::printf("\n ");
        print_variable(table, description.dependencies, at_start, table.variables[i]);
    });
    std::printf("}\n");
}
