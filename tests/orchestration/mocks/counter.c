/* Counts the ticks of a clock, the one that ticks included; every third ticks another clock, which holds the count */
#define UPDATE
#include "foreign.h"

static int calculate(Model *m) {
    const int next = m->count[tick] + m->active[tick];
    m->v[count] = next;
    m->active[every_third] = m->active[tick] && next % 3 == 0;
    if (m->active[every_third]) m->v[held] = next;
    return 0;
}
static int advance(Model *m, double t, double h) { return (void)m, 0; }
static void update(Model *m) { m->count[tick] += m->active[tick]; }
