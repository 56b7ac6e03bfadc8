/* A counter for a clock of every kind, the tick that goes on included. `growing` ticks at 0.1, 0.3, 0.6, 1.0 ...; the
 * third tick of `steady` starts the countdown of `alarm`: 0.07 s. `last` is the time of the last tick of `steady`,
 * `sampled` the input then; `told` the interval that the importer has set. */
#define UPDATE
#define INTERVAL
#include "foreign.h"

static const int clocks[] = {steady, third, given, asked, growing, alarm};
static const int counters[] = {steady_n, third_n, given_n, asked_n, growing_n, alarm_n};

static int calculate(Model *m) {
    for (int i = 0; i < 6; ++i)
        if (m->active[clocks[i]]) m->v[counters[i]] = m->count[clocks[i]] + 1;
    if (m->active[steady]) {
        m->v[last] = m->time;
        m->v[sampled] = m->v[u];
    }
    m->v[told] = m->given_interval[given];
    return 0;
}
static int advance(Model *m, double t, double h) { return (void)m, 0; }
static void update(Model *m) {
    for (int i = 0; i < 6; ++i) m->count[clocks[i]] += m->active[clocks[i]];
}
static int interval(Model *m, unsigned vr, double *T) {
    if (vr == asked) {
        *T = (double)m->v[period];
        return fmi3IntervalChanged;
    }
    if (vr == growing) {
        *T = 0.1 * (1 + m->count[growing]);
        return fmi3IntervalChanged;
    }
    if (vr != alarm) return -1;
    if (m->count[steady] < 3 || m->count[alarm]) return fmi3IntervalNotYetKnown;
    if (m->given_interval[alarm] > 0) return fmi3IntervalUnchanged;
    *T = m->given_interval[alarm] = 0.07; /* announced once */
    return fmi3IntervalChanged;
}
