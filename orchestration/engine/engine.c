/* The stepping loop of co-simulation and the right-hand side of coupled Model Exchange over FMU function pointers.
 *
 * One plan says which values flow where: `get` calls write into the signal buffer, `set` calls gather their values
 * from it. Signals are doubles; other types are converted at the call. All memory belongs to the caller; nothing is
 * allocated here. What a plain FMI call cannot do goes back to Python through `Callback`. */

#include "engine.h"

/* The floating-point control of a thread, which every function in it can change for all: how results are rounded,
 * whether denormal numbers are flushed to zero, and which exceptions trap. */
#if defined(__x86_64__)
#define ROUNDING 0x6000u
#define DENORMALS 0x8040u
static uint32_t control(void) { return __builtin_ia32_stmxcsr() & ~0x3fu; } /* without what has happened */
static void set_control(uint32_t value) { __builtin_ia32_ldmxcsr(value); }
#elif defined(__aarch64__)
#define ROUNDING 0xc00000u
#define DENORMALS 0x1000000u
static uint32_t control(void) {
    uint64_t value;
    __asm__ volatile("mrs %0, fpcr" : "=r"(value));
    return (uint32_t)value;
}
static void set_control(uint32_t value) { __asm__ volatile("msr fpcr, %0" : : "r"((uint64_t)value)); }
#else
#define ROUNDING 0u
#define DENORMALS 0u
static uint32_t control(void) { return 0; }
static void set_control(uint32_t value) { (void)value; }
#endif

/* Put the thread's control back; return what was changed. */
EXPORT int32_t adcs_restore(uint32_t value) {
    const uint32_t difference = control() ^ value;
    if (!difference) return 0;
    set_control(value);
    return (difference & ROUNDING ? CHANGED_ROUNDING : 0) | (difference & DENORMALS ? CHANGED_DENORMALS : 0) |
           (difference & ~(ROUNDING | DENORMALS) ? CHANGED_TRAPS : 0);
}

/* After a call of a component. */
static void look_after(const Plan* plan, Component* c) {
    if (c->foreign) c->changed |= adcs_restore(plan->control);
}

EXPORT uint32_t adcs_control(void) { return control(); }

EXPORT size_t adcs_plan_size(void) { return sizeof(Plan); }

bool engine_fail(Plan* plan, int reason, int kind, size_t component, size_t call, int status, size_t element) {
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

/* Above 2^53 a double does not hold every integer: such values are refused rather than rounded. */
#define EXACT (INT64_C(1) << 53)

/* Of a factor or offset between integers: _MOST of propagation.py. */
#define MOST 0x1p70

__extension__ typedef __int128 Wide; /* holds every product of the two */

/* Infinity, which no integer takes, where a double could not hold the result. */
static double whole(const Piece* piece, double value) {
    if (!(fabs(value) <= (double)EXACT && fabs(piece->factor) <= MOST && fabs(piece->offset) <= MOST)) return INFINITY;
    const Wide sum = (Wide)piece->factor * (Wide)value + (Wide)piece->offset;
    return sum < -EXACT || sum > EXACT ? (double)INFINITY : (double)sum;
}

/* Values outside the mapping become NaN, which no type takes. */
static double mapped(const Piece* piece, double value) {
    for (size_t i = 0; i < piece->n_mapping; ++i) {
        if (piece->mapping[i].from == value) return piece->mapping[i].to;
    }
    return NAN;
}

static double* gather(const double* signals, const Piece* pieces, size_t n_pieces, double* to) {
    for (size_t p = 0; p < n_pieces; ++p) {
        const Piece* piece = &pieces[p];
        const double* from = signals + piece->from;
        if (piece->plain) {
            for (size_t i = 0; i < piece->n; ++i) *to++ = from[i];
        } else if (piece->mapping) {
            for (size_t i = 0; i < piece->n; ++i) *to++ = mapped(piece, from[i]);
        } else if (piece->whole) {
            for (size_t i = 0; i < piece->n; ++i) *to++ = whole(piece, from[i]);
        } else {
            for (size_t i = 0; i < piece->n; ++i) *to++ = piece->factor * from[i] + piece->offset;
        }
    }
    return to;
}

#define PACK(TYPE, LOW, HIGH)                                              \
    for (; i < n; ++i) {                                                   \
        if (!(values[i] >= (LOW) && values[i] <= (HIGH))) return i;        \
        ((TYPE*)raw)[i] = (TYPE)values[i];                                 \
        if ((double)((TYPE*)raw)[i] != values[i]) return i; /* fraction */ \
    }                                                                      \
    return n
/* Compared as integers: 2^53 + 1 is 2^53 as a double. */
#define UNPACK(TYPE, BEYOND)                      \
    for (; i < n; ++i) {                          \
        const TYPE value = ((const TYPE*)raw)[i]; \
        if (BEYOND) return i;                     \
        values[i] = (double)value;                \
    }                                             \
    return n

/* Both return the index of the first value that does not fit, n if all do. */
static size_t pack(int32_t type, const double* values, size_t n, void* raw) {
    size_t i = 0;
    switch (type) {
        case FLOAT32:
            for (; i < n; ++i) {
                ((float*)raw)[i] = (float)values[i];
                if (!isfinite(((float*)raw)[i])) return i;
            }
            return n;
        case INT8:
            PACK(int8_t, INT8_MIN, INT8_MAX);
        case UINT8:
            PACK(uint8_t, 0, UINT8_MAX);
        case INT16:
            PACK(int16_t, INT16_MIN, INT16_MAX);
        case UINT16:
            PACK(uint16_t, 0, UINT16_MAX);
        case INT32:
            PACK(int32_t, INT32_MIN, INT32_MAX);
        case UINT32:
            PACK(uint32_t, 0, UINT32_MAX);
        case INT64:
            PACK(int64_t, (double)-EXACT, (double)EXACT);
        case UINT64:
            PACK(uint64_t, 0, (double)EXACT);
        case BOOL8:
            PACK(uint8_t, 0, 1);
        default:
            PACK(int32_t, 0, 1); /* BOOL32 */
    }
}

static size_t unpack(int32_t type, const void* raw, size_t n, double* values) {
    size_t i = 0;
    switch (type) {
        case FLOAT32:
            for (; i < n; ++i) values[i] = (double)((const float*)raw)[i];
            return n;
        case INT8:
            UNPACK(int8_t, false);
        case UINT8:
            UNPACK(uint8_t, false);
        case INT16:
            UNPACK(int16_t, false);
        case UINT16:
            UNPACK(uint16_t, false);
        case INT32:
            UNPACK(int32_t, false);
        case UINT32:
            UNPACK(uint32_t, false);
        case INT64:
            UNPACK(int64_t, value > EXACT || value < -EXACT);
        case UINT64:
            UNPACK(uint64_t, value > (uint64_t)EXACT);
        case BOOL8:
            for (; i < n; ++i) values[i] = ((const uint8_t*)raw)[i] != 0;
            return n;
        default: /* BOOL32 */
            for (; i < n; ++i) values[i] = ((const int32_t*)raw)[i] != 0;
            return n;
    }
}

static void at(Plan* plan, int32_t doing, size_t component) {
    plan->where->now = (uint32_t)doing | (uint64_t)component << 32; /* in one piece, for who reads it meanwhile */
}

static bool execute(Plan* plan, size_t index, double time) {
    const Call* call = &plan->calls[index];
    at(plan, call->kind, call->component);
    if (call->kind == SOLVE) {
        const int raised = plan->callback(SOLVE, (int32_t)call->component, time, 0);
        return raised ? engine_fail(plan, RAISED, SOLVE, call->component, index, 0, 0) : true;
    }
    Component* c = &plan->components[call->component];
    const size_t n = call->n_values;
    void* data = call->raw ? call->raw : call->values;
    if (call->kind == SET) {
        gather(plan->signals, call->pieces, call->n_pieces, call->values);
        const size_t bad = call->raw     ? pack(call->type, call->values, n, call->raw)
                           : call->plain ? n
                                         : first_not_finite(call->values, n);
        if (bad < n) return engine_fail(plan, DOES_NOT_FIT, SET, call->component, index, 0, bad);
    }
    const int status = c->fmi == 2 ? call->access.fmi2(c->instance, call->references, call->n_references, data)
                                   : call->access.fmi3(c->instance, call->references, call->n_references, data, n);
    look_after(plan, c);
    if (!good(status)) return engine_fail(plan, STATUS, call->kind, call->component, index, status, 0);
    if (call->kind == GET) {
        if (call->raw) {
            const size_t bad = unpack(call->type, call->raw, n, call->values);
            if (bad < n) return engine_fail(plan, DOES_NOT_FIT, GET, call->component, index, status, bad);
        }
        const size_t bad = first_not_finite(call->values, n);
        if (bad < n) return engine_fail(plan, NOT_FINITE, GET, call->component, index, status, bad);
    }
    return true;
}

/* A division costs as much as a small call; nearly always there is none to be made. */
static bool due(int64_t every, int64_t k) { return every == 1 || k % every == 0; }

static bool propagate(Plan* plan, int64_t k, double time) {
    for (size_t i = 0; i < plan->n_calls; ++i) {
        const Call* call = &plan->calls[i];
        if (!due(call->every, k)) continue;
        if (plan->stop > 1) return engine_fail(plan, GIVEN_UP, call->kind, 0, i, 0, 0);
        if (!execute(plan, i, time)) return false;
    }
    return true;
}

/* Of a step, two times that differ by less are the same: SNAP of grid.py. */
#define SNAP 1e-9

/* An FMI 3 step asks to end the simulation at the time `last`, which not every FMU gives where it does not return
 * early: note it, if the step is done. */
static bool end_at(Plan* plan, size_t i, int64_t k, double time, double step, bool early, double last) {
    plan->returned = last;
    if (!(last >= time + step - SNAP * step)) {
        if (last >= time) return engine_fail(plan, TERMINATED, DO_STEP, i, 0, 0, 0);
        if (early) return engine_fail(plan, EARLY_RETURN, DO_STEP, i, 0, 0, 0);
    }
    if (k < plan->ending) {
        plan->ending = k;
        plan->ender = (int32_t)i;
    }
    return true;
}

/* What a callback has answered to a step. */
static bool stepped(Plan* plan, size_t i, int64_t k, double time, double step, int answer) {
    if (answer == 2) return end_at(plan, i, k, time, step, false, time + step);
    return answer ? engine_fail(plan, RAISED, DO_STEP, i, 0, 0, 0) : true;
}

/* To point k. */
static bool do_step(Plan* plan, size_t i, int64_t k, double time, double step) {
    Component* c = &plan->components[i];
    at(plan, DO_STEP, i);
    if (!c->do_step.fmi2) {
        const int answer = plan->callback(DO_STEP, (int32_t)i, time, step);
        look_after(plan, c);
        return stepped(plan, i, k, time, step, answer);
    }
    bool event = false, terminate = false, early = false;
    double last = time + step; /* which not all FMUs set */
    const int status =
        c->fmi == 2 ? c->do_step.fmi2(c->instance, time, step, c->never_returns)
                    : c->do_step.fmi3(c->instance, time, step, c->never_returns, &event, &terminate, &early, &last);
    look_after(plan, c);
    if (status == DISCARD) return stepped(plan, i, k, time, step, plan->callback(DISCARDED, (int32_t)i, time, step));
    if (!good(status)) return engine_fail(plan, STATUS, DO_STEP, i, 0, status, 0);
    if (terminate) return end_at(plan, i, k, time, step, early, last);
    if (early) {
        plan->returned = last;
        return engine_fail(plan, EARLY_RETURN, DO_STEP, i, 0, status, 0);
    }
    return true;
}

static void arrive(Plan* plan, int64_t k) {
    for (size_t i = 0; i < plan->n_delays; ++i) {
        const Delay* d = &plan->delays[i];
        memcpy(plan->signals + d->to, d->history + (size_t)(k % d->steps) * d->n, d->n * sizeof(double));
    }
}

static void leave(Plan* plan, int64_t k) {
    for (size_t i = 0; i < plan->n_delays; ++i) {
        const Delay* d = &plan->delays[i];
        memcpy(d->history + (size_t)(k % d->steps) * d->n, plan->signals + d->from, d->n * sizeof(double));
    }
}

void engine_begin(Plan* plan) {
    plan->failure.reason = 0;
    plan->control = control();
    ++plan->where->count;
}

bool engine_end(Plan* plan, bool well) {
    at(plan, IDLE, 0);
    return well;
}

EXPORT bool adcs_propagate(Plan* plan, int64_t k, double time) {
    engine_begin(plan);
    plan->where->k = k;
    arrive(plan, k);
    return engine_end(plan, propagate(plan, k, time));
}

/* From k to k+1. A component whose next communication point lies beyond `last` is not asked to go there. */
static bool move_on(Plan* plan, int64_t k, int64_t last, double time, double step) {
    leave(plan, k);
    for (size_t i = 0; i < plan->n_components; ++i) {
        const int64_t every = plan->components[i].every;
        if (!due(every, k) || k + every > last) continue;
        if (plan->stop > 1) return engine_fail(plan, GIVEN_UP, DO_STEP, i, 0, 0, 0);
        if (!do_step(plan, i, k + every, time, (double)every * step)) return false;
    }
    return true;
}

EXPORT bool adcs_move_on(Plan* plan, int64_t k, int64_t last, double time, double step) {
    engine_begin(plan);
    plan->where->k = k;
    return engine_end(plan, move_on(plan, k, last, time, step));
}

/* Points first .. first+count-1 of a co-simulation whose last point is `last`: take what comes from outside (a row of
 * n_external values for each point, or null), propagate at t_k = start + k*step, record every record_every-th point,
 * move on (not from the last one). plan->where->k says where it ended: at first+count, or before it where a call failed
 * or it was told to stop, or at the point, recorded, at which a component ends the simulation. Returns the number of rows
 * written. */
static int64_t steps(Plan* plan, double start, double step, int64_t first, int64_t count, int64_t last,
                     const double* external, double* rows) {
    int64_t written = 0;
    Where* where = plan->where;
    for (int64_t k = first; k < first + count && !plan->stop; ++k) {
        const double time = start + (double)k * step;
        where->k = k;
        if (external) {
            memcpy(plan->signals, external, plan->n_external * sizeof(double));
            external += plan->n_external;
        }
        arrive(plan, k);
        if (!propagate(plan, k, time)) return written;
        if (plan->record_every == 1 || k % plan->record_every == 0) {
            rows = gather(plan->signals, plan->record, plan->n_record, rows);
            ++written;
            atomic_signal_fence(memory_order_release); /* the row comes first, also for who reads it after a crash */
            ++where->rows;
        }
        if (k >= plan->ending) {
            plan->returned = time;
            engine_fail(plan, TERMINATED, DO_STEP, (size_t)plan->ender, 0, 0, 0);
            return written;
        }
        if (k < last && !move_on(plan, k, last, time, step)) return written;
        where->k = k + 1;
    }
    return written;
}

EXPORT int64_t adcs_steps(Plan* plan, double start, double step, int64_t first, int64_t count, int64_t last,
                          const double* external, double* rows) {
    engine_begin(plan);
    const int64_t written = steps(plan, start, step, first, count, last, external, rows);
    engine_end(plan, true);
    return written;
}

/* The last time that is not after t; the first where all are. */
static size_t find(const Lines* l, double t) {
    size_t low = l->current, high = low + 1;
    if (!(l->times[low] <= t && (high == l->n_times || t < l->times[high]))) {
        for (low = 0, high = l->n_times; high - low > 1;) {
            const size_t middle = low + (high - low) / 2;
            if (l->times[middle] <= t) {
                low = middle;
            } else {
                high = middle;
            }
        }
    }
    return low;
}

static void follow(Plan* plan, double t) {
    for (size_t i = 0; i < plan->n_lines; ++i) {
        Lines* l = &plan->lines[i];
        const size_t k = l->current = find(l, t);
        const double* y = l->values + k * l->n;
        const double* slope = l->slopes + k * l->n;
        const double since = t - l->times[k];
        for (size_t j = 0; j < l->n; ++j) plan->signals[l->to + j] = since > 0 ? slope[j] * since + y[j] : y[j];
    }
}

bool engine_evaluate(Plan* plan, double time, const double* states, double* derivatives, double* row) {
    const double* x = states;
    follow(plan, time);
    for (size_t i = 0; i < plan->n_components; ++i) {
        Component* c = &plan->components[i];
        at(plan, SET_TIME, i);
        int status = c->set_time(c->instance, time);
        look_after(plan, c);
        if (!good(status)) return engine_fail(plan, STATUS, SET_TIME, i, 0, status, 0);
        if (c->n_states == 0) continue;
        at(plan, SET_STATES, i);
        status = c->set_states(c->instance, x, c->n_states);
        look_after(plan, c);
        if (!good(status)) return engine_fail(plan, STATUS, SET_STATES, i, 0, status, 0);
        x += c->n_states;
    }
    if (!propagate(plan, 0, time)) return false;
    if (row) gather(plan->signals, plan->record, plan->n_record, row);
    for (size_t i = 0; derivatives && i < plan->n_components; ++i) {
        Component* c = &plan->components[i];
        if (c->n_states == 0) continue;
        at(plan, GET_DERIVATIVES, i);
        const int status = c->get_derivatives(c->instance, derivatives, c->n_states);
        look_after(plan, c);
        if (!good(status)) return engine_fail(plan, STATUS, GET_DERIVATIVES, i, 0, status, 0);
        const size_t bad = first_not_finite(derivatives, c->n_states);
        if (bad < c->n_states) return engine_fail(plan, NOT_FINITE, GET_DERIVATIVES, i, 0, status, bad);
        derivatives += c->n_states;
    }
    return true;
}

bool engine_indicators(Plan* plan, double* indicators) {
    for (size_t i = 0; i < plan->n_components; ++i) {
        Component* c = &plan->components[i];
        if (c->n_indicators == 0) continue;
        at(plan, GET_INDICATORS, i);
        const int status = c->get_indicators(c->instance, indicators, c->n_indicators);
        look_after(plan, c);
        if (!good(status)) return engine_fail(plan, STATUS, GET_INDICATORS, i, 0, status, 0);
        const size_t bad = first_not_finite(indicators, c->n_indicators);
        if (bad < c->n_indicators) return engine_fail(plan, NOT_FINITE, GET_INDICATORS, i, 0, status, bad);
        indicators += c->n_indicators;
    }
    return true;
}

EXPORT bool adcs_evaluate(Plan* plan, double time, const double* states, double* derivatives, double* row) {
    engine_begin(plan);
    return engine_end(plan, engine_evaluate(plan, time, states, derivatives, row));
}
