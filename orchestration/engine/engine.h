/* What a plan is made of, and what its parts in C share. Mirrored by __init__.py. */

#ifndef ADCS_ENGINE_H
#define ADCS_ENGINE_H

#include <math.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef uint32_t Reference;

typedef union {
    int (*fmi2)(void*, const Reference*, size_t, void*);
    int (*fmi3)(void*, const Reference*, size_t, void*, size_t);
} Access;

typedef union {
    int (*fmi2)(void*, double, double, int);
    int (*fmi3)(void*, double, double, bool, bool*, bool*, bool*, double*);
} DoStep;

typedef struct {
    void* instance;
    DoStep do_step;                 /* Co-Simulation only; null: step it through the plan's callback */
    int (*set_time)(void*, double); /* Model Exchange only, as the next three */
    int (*set_states)(void*, const double*, size_t);
    int (*get_derivatives)(void*, double*, size_t);
    int (*get_indicators)(void*, double*, size_t);
    size_t n_states, n_indicators;
    int64_t every;      /* communicates at k = 0, every, 2*every ... */
    int32_t fmi;        /* 2 or 3 */
    bool foreign;       /* its calls are looked after: what they change of the thread is changed back */
    bool never_returns; /* to a state before a step */
    int32_t changed;
} Component;

enum { CHANGED_ROUNDING = 1, CHANGED_DENORMALS = 2, CHANGED_TRAPS = 4 };

enum { GET, SET, SOLVE, DO_STEP, SET_TIME, SET_STATES, GET_DERIVATIVES, DISCARDED, GET_INDICATORS };
enum { FLOAT64, FLOAT32, INT8, UINT8, INT16, UINT16, INT32, UINT32, INT64, UINT64, BOOL8, BOOL32 };

typedef struct {
    double from, to;
} Pair;

typedef struct {
    size_t from, n; /* of the signal buffer */
    double factor, offset;
    const Pair* mapping; /* null: factor * signal + offset */
    size_t n_mapping;
    bool plain; /* as it is, to the last bit */
    bool whole; /* for an integer, which must not be rounded */
} Piece;

typedef struct {
    const Reference* references;
    size_t n_references;
    double* values; /* get: into the signal buffer; set: its own staging buffer */
    size_t n_values;
    void* raw;           /* values of another type than double; null: double */
    const Piece* pieces; /* set: what is gathered into values */
    size_t n_pieces;
    Access access;
    int32_t kind; /* GET, SET or SOLVE */
    int32_t type;
    uint32_t component; /* SOLVE: number of the loop */
    int64_t every;      /* made at k = 0, every, 2*every ... */
    bool plain;         /* set: signals go as they are, and are finite therefore */
} Call;

typedef struct {
    size_t from, to, n; /* signals that are delayed, and where they arrive */
    int64_t steps;
    double* history; /* (steps, n): what left at k is at k modulo steps */
} Delay;

/* Signals from outside that go along straight lines between times, and hold before the first and after the last. */
typedef struct {
    const double* times;  /* (n_times), increasing */
    const double* values; /* (n_times, n) */
    const double* slopes; /* (n_times, n) from each time to the next; 0 at the last */
    size_t n_times, n;
    size_t to;      /* of the signal buffer */
    size_t current; /* index of the time found last */
} Lines;

enum { STATUS = 1, NOT_FINITE, TERMINATED, EARLY_RETURN, DOES_NOT_FIT, RAISED, GIVEN_UP };

#define DISCARD 2 /* fmi2Discard and fmi3Discard */

typedef struct {
    int32_t reason;
    int32_t kind;      /* of the call that failed */
    int32_t component; /* index */
    int32_t call;      /* index in the plan, for GET, SET and SOLVE */
    int32_t status;    /* as returned by the FMU */
    int32_t element;   /* of the first value that is wrong */
} Failure;

/* Where the loop is, in memory that may be a file's, so that it can be read when the process has died; and by other
 * threads. Larger in Python, which notes its own calls behind it. */
typedef struct {
    volatile int64_t k;
    volatile int64_t rows;  /* that are complete */
    volatile int64_t count; /* goes up whenever the engine is called */
    volatile uint64_t now;  /* the call that is going on, IDLE if none; in the upper half, its component */
} Where;

enum { IDLE = -1 };

/* 0: done, 1: it raised, 2: done, and the component asks to end the simulation. DISCARDED: go on from a step that was
 * discarded, which may be how an FMI 2 FMU ends the simulation. */
typedef int (*Callback)(int32_t kind, int32_t number, double time, double step);

typedef struct {
    Component* components;
    size_t n_components;
    const Call* calls;
    size_t n_calls;
    double* signals;
    size_t n_external; /* the first signals come from outside */
    const Delay* delays;
    size_t n_delays;
    Lines* lines; /* followed by engine_evaluate only */
    size_t n_lines;
    const Piece* record; /* what makes up a row */
    size_t n_record;
    int64_t record_every;
    Callback callback; /* solves a loop, or steps a component */
    Failure failure;
    int64_t ending;  /* the point at which the simulation ends, because a component has asked for it */
    int32_t ender;   /* index of the component */
    double returned; /* the time at which a step that failed returned, where FMI 3 says it */
    Where* where;
    uint32_t control;      /* as it was when the engine was called */
    volatile int32_t stop; /* written by other threads; 1: return before the next point; 2: make no further call */
} Plan;

/* Between these two nobody outside is at work. `end` returns what it is given. */
void engine_begin(Plan* plan);
bool engine_end(Plan* plan, bool well);

/* Notes a failure, and returns false. */
bool engine_fail(Plan* plan, int reason, int kind, size_t component, size_t call, int status, size_t element);

/* All components as one ordinary differential equation: values at (time, states), then the derivatives, if wanted, and
 * the row, if wanted. Returns false when a call failed. */
bool engine_evaluate(Plan* plan, double time, const double* states, double* derivatives, double* row);

/* The event indicators of all components, where they were brought by `engine_evaluate`. */
bool engine_indicators(Plan* plan, double* indicators);

#endif
