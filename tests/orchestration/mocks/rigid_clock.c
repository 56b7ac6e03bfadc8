/* A clock in an FMU whose steps are all of one size */
#define UPDATE
#include "foreign.h"

static int calculate(Model *m) { return m->v[steady_n] = m->count[steady] + m->active[steady], 0; }
static int advance(Model *m, double t, double h) { return (void)m, 0; }
static void update(Model *m) { m->count[steady] += m->active[steady]; }
