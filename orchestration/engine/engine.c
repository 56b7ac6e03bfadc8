/* The stepping loop of co-simulation and the right-hand side of coupled Model Exchange over FMU function pointers.
 *
 * One plan says which values flow where: `get` calls write straight into the signal buffer, `set` calls gather their
 * values from it. All memory belongs to the caller; nothing is allocated here. Mirrored by __init__.py. */

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef uint32_t Reference;

typedef union {
    int (*fmi2)(void*, const Reference*, size_t, double*);
    int (*fmi3)(void*, const Reference*, size_t, double*, size_t);
} Access;

typedef union {
    int (*fmi2)(void*, double, double, int);
    int (*fmi3)(void*, double, double, bool, bool*, bool*, bool*, double*);
} DoStep;

typedef struct {
    void* instance;
    Access get, set;
    DoStep do_step; /* Co-Simulation only; the next three Model Exchange only */
    int (*set_time)(void*, double);
    int (*set_states)(void*, const double*, size_t);
    int (*get_derivatives)(void*, double*, size_t);
    size_t n_states;
    int32_t fmi; /* 2 or 3 */
} Component;

enum { GET, SET, DO_STEP, SET_TIME, SET_STATES, GET_DERIVATIVES };

typedef struct {
    size_t from, n;
} Range; /* of the signal buffer */

typedef struct {
    const Reference* references;
    size_t n_references;
    double* values; /* get: into the signal buffer; set: its own staging buffer */
    size_t n_values;
    const Range* ranges; /* set: what is gathered into values */
    size_t n_ranges;
    int32_t kind; /* GET or SET */
    uint32_t component;
} Call;

enum { STATUS = 1, NOT_FINITE, TERMINATED, EARLY_RETURN };

typedef struct {
    int32_t reason;
    int32_t kind;      /* of the call that failed */
    int32_t component; /* index */
    int32_t call;      /* index in the plan, for GET and SET */
    int32_t status;    /* as returned by the FMU */
    int32_t element;   /* of the first value that is not finite */
} Failure;

typedef struct {
    const Component* components;
    size_t n_components;
    const Call* calls;
    size_t n_calls;
    double* signals;
    const Range* record; /* what makes up a row */
    size_t n_record;
    Failure failure;
} Plan;

EXPORT size_t adcs_plan_size(void) { return sizeof(Plan); }

static bool fail(Plan* plan, int reason, int kind, size_t component, size_t call, int status, size_t element) {
    plan->failure = (Failure){reason, kind, (int32_t)component, (int32_t)call, status, (int32_t)element};
    return false;
}

/* fmi2OK and fmi2Warning, fmi3OK and fmi3Warning; anything else, also what no standard knows, is a failure */
static bool good(int status) { return status == 0 || status == 1; }

static size_t first_not_finite(const double* values, size_t n) {
    size_t i = 0;
    while (i < n && isfinite(values[i])) ++i;
    return i;
}

static double* gather(const double* signals, const Range* ranges, size_t n_ranges, double* to) {
    for (size_t r = 0; r < n_ranges; ++r) {
        const double* from = signals + ranges[r].from;
        for (size_t i = 0; i < ranges[r].n; ++i) *to++ = from[i];
    }
    return to;
}

static bool propagate(Plan* plan) {
    for (size_t i = 0; i < plan->n_calls; ++i) {
        const Call* call = &plan->calls[i];
        const Component* c = &plan->components[call->component];
        if (call->kind == SET) gather(plan->signals, call->ranges, call->n_ranges, call->values);
        const Access access = call->kind == SET ? c->set : c->get;
        const int status =
            c->fmi == 2 ? access.fmi2(c->instance, call->references, call->n_references, call->values)
                        : access.fmi3(c->instance, call->references, call->n_references, call->values, call->n_values);
        if (!good(status)) return fail(plan, STATUS, call->kind, call->component, i, status, 0);
        if (call->kind == GET) {
            const size_t bad = first_not_finite(call->values, call->n_values);
            if (bad < call->n_values) return fail(plan, NOT_FINITE, GET, call->component, i, status, bad);
        }
    }
    return true;
}

static bool do_steps(Plan* plan, double time, double step) {
    for (size_t i = 0; i < plan->n_components; ++i) {
        const Component* c = &plan->components[i];
        bool event = false, terminate = false, early = false;
        double last = time;
        const int status = c->fmi == 2
                               ? c->do_step.fmi2(c->instance, time, step, 1)
                               : c->do_step.fmi3(c->instance, time, step, true, &event, &terminate, &early, &last);
        if (!good(status)) return fail(plan, STATUS, DO_STEP, i, 0, status, 0);
        if (terminate) return fail(plan, TERMINATED, DO_STEP, i, 0, status, 0);
        if (early) return fail(plan, EARLY_RETURN, DO_STEP, i, 0, status, 0);
    }
    return true;
}

EXPORT bool adcs_propagate(Plan* plan) { return propagate(plan); }

/* Rows first .. first+count-1 of a co-simulation whose last row is `last`: propagate at t_k = start + k*step, record,
 * step on (not from the last row). Returns the number of rows written; fewer than count, or a reason in the failure,
 * say that a call failed. */
EXPORT int64_t adcs_steps(Plan* plan, double start, double step, int64_t first, int64_t count, int64_t last,
                          double* rows) {
    plan->failure.reason = 0;
    for (int64_t k = first; k < first + count; ++k) {
        const double time = start + (double)k * step;
        if (!propagate(plan)) return k - first;
        rows = gather(plan->signals, plan->record, plan->n_record, rows);
        if (k < last && !do_steps(plan, time, step)) return k - first + 1;
    }
    return count;
}

/* All components as one ordinary differential equation: values at (time, states), then the derivatives, if wanted, and
 * the row, if wanted. Returns false when a call failed. */
EXPORT bool adcs_evaluate(Plan* plan, double time, const double* states, double* derivatives, double* row) {
    const double* x = states;
    for (size_t i = 0; i < plan->n_components; ++i) {
        const Component* c = &plan->components[i];
        int status = c->set_time(c->instance, time);
        if (!good(status)) return fail(plan, STATUS, SET_TIME, i, 0, status, 0);
        if (c->n_states == 0) continue;
        status = c->set_states(c->instance, x, c->n_states);
        if (!good(status)) return fail(plan, STATUS, SET_STATES, i, 0, status, 0);
        x += c->n_states;
    }
    if (!propagate(plan)) return false;
    if (row) gather(plan->signals, plan->record, plan->n_record, row);
    for (size_t i = 0; derivatives && i < plan->n_components; ++i) {
        const Component* c = &plan->components[i];
        if (c->n_states == 0) continue;
        const int status = c->get_derivatives(c->instance, derivatives, c->n_states);
        if (!good(status)) return fail(plan, STATUS, GET_DERIVATIVES, i, 0, status, 0);
        const size_t bad = first_not_finite(derivatives, c->n_states);
        if (bad < c->n_states) return fail(plan, NOT_FINITE, GET_DERIVATIVES, i, 0, status, bad);
        derivatives += c->n_states;
    }
    return true;
}
