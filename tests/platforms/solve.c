/* Solves a system as one differential equation with the engine and with the binaries of FMUs, as Python does. Prints a
 * digest of all rows, and the bits of the last one: on two platforms the same, or they do not compute the same.
 *
 * solve BINARY...   of each component, in the order of system.h, which solve_program.py writes */
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"
#include "walk.c"

bool adcs_propagate(Plan* plan, int64_t k, double time); /* engine.c */
bool adcs_evaluate(Plan* plan, double time, const double* states, double* derivatives, double* row);

#ifdef _WIN32 /* windows.h has other things by the names of engine.h */
__declspec(dllimport) void* LoadLibraryA(const char*);
__declspec(dllimport) void* GetProcAddress(void*, const char*);
#define load LoadLibraryA
#define find GetProcAddress
#else
#include <dlfcn.h>
#define load(path) dlopen(path, RTLD_NOW)
#define find dlsym
#endif

typedef struct {
    int32_t type; /* as in a call */
    const Reference* references;
    size_t n;
    const void* values;
} Start;

typedef struct {
    const char *name, *token;
    size_t n_states, n_starts;
    const Start* starts;
} Part;

#include "system.h"

static void require(bool good, const char* what) {
    if (good) return;
    fprintf(stderr, "%s failed\n", what);
    exit(1);
}

static void ignore(fmi2ComponentEnvironment e, fmi2String i, fmi2Status s, fmi2String c, fmi2String text, ...) {
    (void)e, (void)i, (void)s, (void)c, (void)text;
}
static const fmi2CallbackFunctions callbacks = {ignore, calloc, free, NULL, NULL};

static void* libraries[N_PARTS];
static Component components[N_PARTS];
static Where where;

static void* function(size_t part, const char* name) {
    void* found = find(libraries[part], name);
    require(found != NULL, name);
    return found;
}

/* Call a function of a component with more arguments than itself. */
#define CALL(part, name, ...) \
    require(((name##TYPE*)function(part, #name))(components[part].instance, __VA_ARGS__) == fmi2OK, #name)
#define CALL_ALONE(part, name) \
    require(((name##TYPE*)function(part, #name))(components[part].instance) == fmi2OK, #name)

static const char* access_of(int32_t kind, int32_t type) {
    if (type == FLOAT64) return kind == GET ? "fmi2GetReal" : "fmi2SetReal";
    if (type == INT32) return kind == GET ? "fmi2GetInteger" : "fmi2SetInteger";
    require(type == BOOL32, "finding a type of FMI 2");
    return kind == GET ? "fmi2GetBoolean" : "fmi2SetBoolean";
}

static void bind(Plan* plan, Call* calls) {
    plan->components = components;
    plan->n_components = N_PARTS;
    plan->calls = calls;
    plan->where = &where;
    for (size_t i = 0; i < plan->n_calls; ++i) {
        calls[i].access.fmi2 = function(calls[i].component, access_of(calls[i].kind, calls[i].type));
    }
}

static void begin(size_t i, const char* binary) {
    const Part* part = &parts[i];
    Component* c = &components[i];
    libraries[i] = load(binary);
    require(libraries[i] != NULL, binary);
    *c = (Component){
        .set_time = function(i, "fmi2SetTime"),
        .set_states = function(i, "fmi2SetContinuousStates"),
        .get_derivatives = function(i, "fmi2GetDerivatives"),
        .n_states = part->n_states,
        .every = 1,
        .fmi = 2,
    };
    c->instance = ((fmi2InstantiateTYPE*)function(i, "fmi2Instantiate"))(part->name, fmi2ModelExchange, part->token, "",
                                                                         &callbacks, fmi2False, fmi2False);
    require(c->instance != NULL, part->name);
    for (size_t s = 0; s < part->n_starts; ++s) {
        const Start* start = &part->starts[s];
        Access access;
        access.fmi2 = function(i, access_of(SET, start->type));
        require(access.fmi2(c->instance, start->references, start->n, (void*)start->values) == fmi2OK, "a start value");
    }
    CALL(i, fmi2SetupExperiment, fmi2False, 0, 0, fmi2False, 0);
    CALL_ALONE(i, fmi2EnterInitializationMode);
}

/* Until nothing changes, and nobody asks for another time. */
static void settle(void) {
    static double before[sizeof flow_signals / sizeof *flow_signals];
    require(adcs_propagate(&flow, 0, 0), "propagating");
    bool again;
    do {
        again = false;
        memcpy(before, flow_signals, sizeof before);
        for (size_t i = 0; i < N_PARTS; ++i) {
            fmi2EventInfo info = {0};
            CALL(i, fmi2NewDiscreteStates, &info);
            require(!info.nextEventTimeDefined && !info.terminateSimulation, "being smooth");
            again = again || info.newDiscreteStatesNeeded;
        }
        require(adcs_propagate(&flow, 0, 0), "propagating");
    } while (again || memcmp(before, flow_signals, sizeof before));
}

static double times[N_ROWS], table[N_ROWS][ROW_SIZE], states[N_ROWS][N_STATES];
static int64_t points[N_ROWS];

static void solve(void) {
    static double tolerances[N_STATES], at_origin[N_STATES], before[N_STATES], x[N_STATES], trial[N_STATES];
    static double stages[EXTENDED][N_STATES], extension[DEGREE][N_STATES], uncertain[N_STATES];
    static Taken taken = {.shortest = INFINITY};
    static Walk w = {.flow = &flow, .rows = &rows, .n = N_STATES, .row_size = ROW_SIZE, .tolerances = tolerances,
        .relative = RELATIVE, .longest = LONGEST, .instant = INSTANT, .looks = 1, .apart = INFINITY, .end = END,
        .most_steps = INT64_MAX, .at_origin = at_origin, .before = before, .x = x, .trial = trial, .stages = *stages,
        .extension = *extension, .uncertain = uncertain, .taken = &taken};
    for (size_t i = 0, first = 0; i < N_PARTS; first += parts[i++].n_states) {
        CALL_ALONE(i, fmi2EnterContinuousTimeMode);
        if (parts[i].n_states == 0) continue;
        CALL(i, fmi2GetContinuousStates, x + first, parts[i].n_states);
        CALL(i, fmi2GetNominalsOfContinuousStates, tolerances + first, parts[i].n_states);
    }
    for (size_t i = 0; i < N_STATES; ++i) tolerances[i] *= ABSOLUTE;
    for (int64_t k = 0; k < N_ROWS; ++k) times[points[k] = k] = (double)k * STEP;
    Output out = {times, points, N_ROWS, 0, *table, *states, false};
    require(adcs_walk(&w, END, END, &out) == THERE, "the walk");
    require(out.written == N_ROWS - 1, "writing all rows but the last");
    require(adcs_evaluate(&rows, w.time, x, NULL, table[N_ROWS - 1]), "the last row");
}

int main(int argc, char** argv) {
    require(argc == N_PARTS + 1, "reading one binary for each component");
    for (size_t i = 0; i < N_PARTS; ++i) begin(i, argv[i + 1]);
    bind(&initial, initial_calls);
    bind(&flow, flow_calls);
    bind(&rows, rows_calls);
    require(adcs_propagate(&initial, 0, 0), "propagating");
    for (size_t i = 0; i < N_PARTS; ++i) CALL_ALONE(i, fmi2ExitInitializationMode);
    settle();
    solve();
    uint64_t digest = 0xcbf29ce484222325U; /* FNV-1a */
    const unsigned char* bytes = (const unsigned char*)table;
    for (size_t i = 0; i < sizeof table; ++i) digest = (digest ^ bytes[i]) * 0x100000001b3U;
    printf("%016llx\n", (unsigned long long)digest);
    for (size_t i = 0; i < ROW_SIZE; ++i) {
        uint64_t bits;
        memcpy(&bits, &table[N_ROWS - 1][i], sizeof bits);
        printf("%016llx ", (unsigned long long)bits);
    }
    printf("\n");
    return 0;
}
