/* The solution of coupled Model Exchange, step by step, with rows between the ends of steps: DOP853.
 *
 * Steps are as long as the tolerances let them be, and end at none of the rows, which are taken from the continuous
 * extension of the step that they lie in. Nothing depends on how many rows are asked for at once. All memory belongs to
 * the caller. The only function of the C library whose result counts is sqrt, which is exact everywhere. Mirrored by
 * walk.py. */

#include "dop853.h"
#include "engine.h"

#define SAFETY 0.9
#define LEAST 0.2 /* of a step's length, the next one's */
#define MOST 10.0
#define NEAR 1e-3        /* of a step, what its continuous extension gives beyond its ends as well */
#define ROUNDING 0x1p-51 /* of a number, what is lost of it in an operation or two */
#define RETRIES 12       /* of a step that leads out of the states that a component can take */

/* How a walk ends. ROWS_FAILED: a call of the plan of the rows did. */
enum { THERE, WRITTEN, LOOK, STOPPED, FAILED, ROWS_FAILED, TOO_SHORT, TOO_MANY };

typedef struct {
    int64_t evaluations, steps, rejected;
    double shortest, longest; /* step */
    int64_t since;            /* steps since the last row */
    double row;               /* its time */
} Taken;

typedef struct {
    Plan* flow;               /* gives derivatives, and event indicators */
    Plan* rows;               /* gives rows */
    int (*outside)(double);   /* brings what comes from outside to a time; null: nothing does */
    size_t n, row_size;       /* number of states, and of doubles in a row */
    const double* tolerances; /* (n) absolute */
    double relative;
    double longest; /* a step may be */
    double instant; /* times that differ by less are the same */
    double looks;   /* into each step for event indicators, or more: */
    double apart;   /* they are not farther from each other */
    size_t n_indicators;
    double end;         /* of the run */
    bool watched;       /* somebody outside is to be told of each step */
    int64_t most_steps; /* from one row to the next */

    bool started;       /* the derivatives at `time` are there, as stage STAGES */
    bool extended;      /* the continuous extension of the last step is there */
    double began, time; /* of the last step */
    double floor;       /* no component is brought to a time before this: that of an event */
    double length;      /* that the next step tries; 0: to be found */
    /* From where a run that goes on for longer makes the same steps: the begin of the last step, or of the first that
     * the end of the run cut short. */
    double origin, tried; /* time, and `length` there */
    double* at_origin;    /* (n) */
    bool cut;
    double* before;     /* (n) at `began` */
    double* x;          /* (n) at `time` */
    double* trial;      /* (n) */
    double* stages;     /* (EXTENDED, n) */
    double* extension;  /* (DEGREE, n) */
    double* uncertain;  /* (n) what roundings make of the derivatives at `began` */
    double* indicators; /* (n_indicators) at `time` */
    double* look;       /* (n_indicators) */

    double asked; /* the time for which a component was asked last */
    Taken* taken;
} Walk;

typedef struct {
    const double* times;   /* (count), increasing */
    const int64_t* points; /* (count) of the run */
    int64_t count, written;
    double* rows;   /* (count, row_size) */
    double* states; /* (count, n) */
    bool counted;   /* they are rows of the run */
} Output;

EXPORT size_t adcs_walk_size(void) { return sizeof(Walk); }

static bool evaluate(Walk* w, Plan* plan, double t, const double* x, double* derivatives, double* row) {
    w->asked = t;
    ++plan->where->count;
    if (derivatives) ++w->taken->evaluations;
    if (w->outside && w->outside(t)) return engine_fail(plan, RAISED, SOLVE, 0, 0, 0, 0);
    return engine_evaluate(plan, t, x, derivatives, row);
}

static bool slope(Walk* w, double t, const double* x, double* to) { return evaluate(w, w->flow, t, x, to, NULL); }

/* to = before + h * sum of a[j] * stage j, for the first m stages. */
static void combine(const Walk* w, const double* a, size_t m, double h, double* to) {
    const size_t n = w->n;
    for (size_t i = 0; i < n; ++i) to[i] = 0;
    for (size_t j = 0; j < m; ++j) {
        if (a[j] == 0) continue;
        for (size_t i = 0; i < n; ++i) to[i] += a[j] * w->stages[j * n + i];
    }
    for (size_t i = 0; i < n; ++i) to[i] = w->before[i] + h * to[i];
}

static bool stage(Walk* w, size_t s, double h, double end) {
    combine(w, A[s], s, h, w->trial);
    const double t = C[s] == 1 ? end : fmin(w->began + C[s] * h, end);
    return slope(w, t, w->trial, w->stages + s * w->n);
}

static double scale(const Walk* w, size_t i, double magnitude) { return w->tolerances[i] + magnitude * w->relative; }

/* The root mean square of what is in units of the tolerances at x. */
static double norm(const Walk* w, const double* v, const double* x) {
    double sum = 0;
    for (size_t i = 0; i < w->n; ++i) {
        const double ratio = v[i] / scale(w, i, fabs(x[i]));
        sum += ratio * ratio;
    }
    return sqrt(sum / (double)w->n);
}

static double eighth_root(double value) { return sqrt(sqrt(sqrt(value))); }

/* One step from `before` at `began` to `end`, with the first stage given: x and the stages. */
static bool attempt(Walk* w, double end) {
    const double h = end - w->began;
    for (size_t s = 1; s < STAGES; ++s) {
        if (!stage(w, s, h, end)) return false;
    }
    combine(w, A[STAGES], STAGES, h, w->x);
    return true;
}

/* The error of what was attempted, in units of the tolerances, or, if they are known, of what roundings make of it. */
static double error_of(const Walk* w, double h, bool known) {
    const size_t n = w->n;
    double sum5 = 0, sum3 = 0;
    for (size_t i = 0; i < n; ++i) {
        double e5 = 0, e3 = 0;
        for (size_t s = 0; s < STAGES; ++s) {
            e5 += E5[s] * w->stages[s * n + i];
            e3 += E3[s] * w->stages[s * n + i];
        }
        double unit = scale(w, i, fmax(fabs(w->before[i]), fabs(w->x[i])));
        if (known) unit = fmax(unit, h * w->uncertain[i]);
        sum5 += (e5 / unit) * (e5 / unit);
        sum3 += (e3 / unit) * (e3 / unit);
    }
    return sum5 == 0 ? 0 : h * sum5 / sqrt((sum5 + 0.01 * sum3) * (double)n);
}

/* What roundings of time and states make of the derivatives: the most of three draws. Where large numbers are
 * subtracted it is more than the tolerances allow, and no step is short enough for them. */
static bool find_uncertain(Walk* w) {
    double* f = w->extension; /* which no one needs within a step */
    for (size_t draw = 0; draw < 3; ++draw) {
        for (size_t i = 0; i < w->n; ++i) w->trial[i] = w->before[i] * (i >> draw & 1 ? 1 - ROUNDING : 1 + ROUNDING);
        if (!slope(w, w->began + ROUNDING * fabs(w->began), w->trial, f)) return false;
        for (size_t i = 0; i < w->n; ++i) {
            w->uncertain[i] = fmax(draw ? w->uncertain[i] : 0, fabs(f[i] - w->stages[i]));
        }
    }
    return true;
}

/* The derivatives at the end of the step, with which it is complete. */
static bool complete(Walk* w, double end) {
    if (!slope(w, end, w->x, w->stages + STAGES * w->n)) return false;
    w->time = end;
    w->started = true;
    w->extended = false;
    return true;
}

/* Whether a call failed because the state that was tried is out of bounds. */
static bool of_the_state(const Failure* failure) {
    return failure->reason == NOT_FINITE || (failure->reason == STATUS && failure->status == DISCARD);
}

/* A length for the first step, from the size of the first two derivatives. */
static double first_length(Walk* w, double span) {
    const double* f0 = w->stages;
    double* f1 = w->stages + w->n;
    const double d0 = norm(w, w->x, w->x), d1 = norm(w, f0, w->x);
    const double h0 = fmin(d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1, span);
    for (size_t i = 0; i < w->n; ++i) w->trial[i] = w->x[i] + h0 * f0[i];
    if (!slope(w, w->time + h0, w->trial, f1)) return h0;
    for (size_t i = 0; i < w->n; ++i) w->trial[i] = f1[i] - f0[i];
    const double d2 = norm(w, w->trial, w->x) / h0, d = fmax(d1, d2);
    const double h1 = d <= 1e-15 ? fmax(1e-6, h0 * 1e-3) : eighth_root(0.01 / d);
    return fmin(fmin(100 * h0, h1), span);
}

/* One step from `before`, of a length that the tolerances allow; 0, or how it failed. */
static int32_t accepted(Walk* w, double bound) {
    const double shortest = 10 * (nextafter(w->began, INFINITY) - w->began);
    if (w->length == 0) w->length = first_length(w, bound - w->began);
    w->length = fmax(w->length, shortest);
    bool rejected = false, known = false;
    for (int retries = 0;;) {
        if (w->flow->stop) return STOPPED;
        w->length = fmin(w->length, w->longest);
        if (w->length < shortest) return TOO_SHORT;
        const double end = fmin(w->began + w->length, bound), h = end - w->began;
        if (end == w->end) w->cut = true;
        double error = INFINITY;
        bool well = attempt(w, end);
        if (well) {
            error = error_of(w, h, known);
            if (!(error < 1) && !known && find_uncertain(w)) {
                known = true;
                error = error_of(w, h, known);
            }
        }
        if (!well || (error < 1 && !complete(w, end))) {
            w->length = 0.1 * h;
            if (!of_the_state(&w->flow->failure) || retries++ == RETRIES || w->length < shortest) return FAILED;
            w->flow->failure.reason = 0;
            continue;
        }
        const double factor = error == 0 ? MOST : SAFETY / eighth_root(error);
        if (error < 1) {
            const double next = h * fmin(factor, rejected ? 1 : MOST);
            w->length = end < bound ? next : fmax(next, w->length); /* one that was cut short says less */
            ++w->taken->steps;
            w->taken->shortest = fmin(w->taken->shortest, h);
            w->taken->longest = fmax(w->taken->longest, h);
            return 0;
        }
        w->length = h * (factor > LEAST ? factor : LEAST); /* also where the error is not a number */
        rejected = true;
        ++w->taken->rejected;
    }
}

/* Take one step, not beyond the bound; 0, or how it failed, where it stays at the end of the step before. */
static int32_t step(Walk* w, double bound) {
    const size_t n = w->n;
    w->began = w->time;
    if (!w->cut) {
        w->origin = w->began;
        w->tried = w->length;
        memcpy(w->at_origin, w->x, n * sizeof(double));
    }
    if (n == 0) {
        w->time = fmin(w->began + w->longest, bound);
        return 0;
    }
    memcpy(w->before, w->x, n * sizeof(double));
    if (w->started) {
        memcpy(w->stages, w->stages + STAGES * n, n * sizeof(double));
    } else if (!slope(w, w->time, w->x, w->stages)) {
        return FAILED;
    }
    w->started = false; /* until this one is complete */
    const int32_t failed = accepted(w, bound);
    if (failed) memcpy(w->x, w->before, n * sizeof(double));
    return failed;
}

/* The state at a time within the last step. */
static bool between(Walk* w, double t, double* to) {
    const size_t n = w->n;
    const double h = w->time - w->began;
    if (n == 0) return true;
    if (t == w->time || h == 0) {
        memcpy(to, w->x, n * sizeof(double));
        return true;
    }
    double* f = w->extension;
    if (!w->extended) {
        for (size_t s = STAGES + 1; s < EXTENDED; ++s) {
            if (!stage(w, s, h, w->time)) return false;
        }
        for (size_t i = 0; i < n; ++i) {
            const double delta = w->x[i] - w->before[i];
            const double first = h * w->stages[i], last = h * w->stages[STAGES * n + i];
            f[i] = delta;
            f[n + i] = first - delta;
            f[2 * n + i] = 2 * delta - (last + first);
        }
        for (size_t d = 3; d < DEGREE; ++d) {
            double* fd = f + d * n;
            for (size_t i = 0; i < n; ++i) fd[i] = 0;
            for (size_t s = 0; s < EXTENDED; ++s) {
                if (D[d - 3][s] == 0) continue;
                for (size_t i = 0; i < n; ++i) fd[i] += D[d - 3][s] * w->stages[s * n + i];
            }
            for (size_t i = 0; i < n; ++i) fd[i] *= h;
        }
        w->extended = true;
    }
    const double u = (t - w->began) / h, v = 1 - u;
    for (size_t i = 0; i < n; ++i) {
        double sum = 0;
        for (size_t d = DEGREE; d-- > 0;) sum = (sum + f[d * n + i]) * (d % 2 ? v : u);
        to[i] = w->before[i] + sum;
    }
    return true;
}

/* Up to where a step gives rows. One within an instant of its end waits for the next: an event there comes first. */
EXPORT double adcs_covered(double began, double time, double instant) {
    return time - fmin(instant, NEAR * (time - began));
}

/* At how many times a step of this length is looked into. */
EXPORT double adcs_looks(double least, double apart, double length) { return fmax(least, ceil(length / apart)); }

static int32_t take_rows(Walk* w, Output* out) {
    Where* where = w->rows->where;
    for (; out->written < out->count; ++out->written) {
        if (!(out->times[out->written] < adcs_covered(w->began, w->time, w->instant))) break;
        const double t = fmax(out->times[out->written], w->floor);
        double* x = out->states + (size_t)out->written * w->n;
        where->k = out->points[out->written];
        if (!between(w, t, x)) return FAILED;
        if (!evaluate(w, w->rows, t, x, NULL, out->rows + (size_t)out->written * w->row_size)) return ROWS_FAILED;
        atomic_signal_fence(memory_order_release); /* the row comes first, also for who reads it after a crash */
        if (out->counted) ++where->rows;
        w->taken->since = 0;
        w->taken->row = t;
    }
    return 0;
}

/* Whether an event indicator changes its domain in the last step, or has to be looked at for another reason. */
static bool crosses(Walk* w) {
    double* now = w->look;
    const double h = w->time - w->began, looks = adcs_looks(w->looks, w->apart, h);
    for (double look = 1; look <= looks; ++look) {
        const double t = look == looks ? w->time : w->began + h * (look / looks);
        if (!between(w, t, w->trial) || !evaluate(w, w->flow, t, w->trial, NULL, NULL)) return true;
        if (!engine_indicators(w->flow, now)) return true;
        for (size_t i = 0; i < w->n_indicators; ++i) {
            if ((now[i] > 0) != (w->indicators[i] > 0)) return true;
        }
    }
    memcpy(w->indicators, now, w->n_indicators * sizeof(double));
    return false;
}

static int32_t walk(Walk* w, double until, double bound, Output* out) {
    for (;;) {
        int32_t failed = take_rows(w, out);
        if (failed) return failed;
        if (out->count && out->written == out->count) return WRITTEN;
        if (w->time >= until) return THERE;
        if (w->flow->stop) return STOPPED;
        if (++w->taken->since > w->most_steps) return TOO_MANY;
        failed = step(w, bound);
        if (failed) return failed;
        if (w->watched || (w->n_indicators && crosses(w))) return LOOK;
    }
}

/* Go on to `until`, or until all rows are written, or there is something to be looked at in the last step, whose rows
 * then are not taken yet. No step leads beyond `bound`. */
EXPORT int32_t adcs_walk(Walk* w, double until, double bound, Output* out) {
    engine_begin(w->flow);
    engine_begin(w->rows);
    const int32_t how = walk(w, until, bound, out);
    engine_end(w->flow, true);
    return how;
}

/* Write the state at a time within the last step. */
EXPORT bool adcs_between(Walk* w, double t, double* to) {
    engine_begin(w->flow);
    return engine_end(w->flow, between(w, t, to));
}

/* Let `to` be where `from` would be, had its last step ended at t, which lies within it. */
EXPORT bool adcs_shorter(const Walk* from, Walk* to, double t) {
    const size_t n = from->n;
    engine_begin(to->flow);
    memcpy(to->before, from->before, n * sizeof(double));
    memcpy(to->stages, from->stages, n * sizeof(double));
    to->began = from->began;
    to->length = from->length;
    to->cut = from->cut;
    to->origin = from->origin;
    to->tried = from->tried;
    memcpy(to->at_origin, from->at_origin, n * sizeof(double));
    to->floor = from->floor;
    return engine_end(to->flow, attempt(to, t) && complete(to, t));
}

/* The right-hand side as CVODE calls it: `given` is what CVodeSetUserData was given. Positive: of this state there are no
 * derivatives, but there may be of one nearer; negative: there will be none. */
typedef struct {
    Walk* walk;
    double* (*values)(void* vector); /* N_VGetArrayPointer */
    Failure failure;                 /* the last one, and the time it was of */
    double failed_at;
} RightHandSide;

EXPORT int adcs_right_hand_side(double t, void* x, void* derivatives, void* given) {
    RightHandSide* f = given;
    Plan* plan = f->walk->flow;
    engine_begin(plan);
    if (engine_end(plan, slope(f->walk, t, f->values(x), f->values(derivatives)))) return 0;
    f->failure = plan->failure;
    f->failed_at = t;
    return of_the_state(&f->failure) ? 1 : -1;
}
